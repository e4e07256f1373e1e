/// \file  Shared functions of readers of annotations. Internal, as it includes simdjson.
#pragma once
#include <algorithm>
#include <cstdint>
#include <exception>
#include <iterator>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/detail/json_entries.h"
#include "enfilade/core/detail/json_records.h"
#include "enfilade/core/threads.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Limit of a record; the longest real ones, RxR's with their timed words, have some 30 kB.
inline constexpr std::size_t kMostRecordBytes = std::size_t{1} << 22U;

/// Reads each record of a list or of lines; `read(element, path)` is called for each. A too large
/// record is a fault ("too-large") instead. After kMostFaultsKept errors the rest is not read.
/// \throws InvalidInput if the text is not JSON
template <class Read>
void for_each_record(std::string_view text, json::Faults& faults, const Read& read);

/// The same on all threads, for files of hundreds of megabytes. `read(element, path, faults)` is
/// called for several records at the same time, with a Faults shared by some of them, and returns a
/// value for each. Values and faults are in the order of the file, and do not depend on the number
/// of threads. A too large record gives Value(). A list is read by one thread.
template <class Value, class Read>
std::vector<Value> read_in_parallel(std::string_view text, json::Faults& faults, const Read& read);

/// The viewpoint ids of a path; reports an empty one.
std::vector<std::string> read_path(json::Element element, const json::Path& path,
                                   json::Faults& faults);
/// A finite number of radians.
Radians read_angle(json::Element element, const json::Path& path, json::Faults& faults);
/// Token ids.
std::vector<std::int32_t> read_tokens(json::Element element, const json::Path& path,
                                      json::Faults& faults);

/// The turns of a dialogue: `role`, `message`, `nav_idx`; reports other roles than CVDN's two.
std::vector<DialogueTurn> read_turns(json::Element element, const json::Path& path,
                                     json::Faults& faults);

/// Words and when they were said: `word`, and `start_time` and `end_time` in seconds, which may be
/// absent.
std::vector<TimedWord> read_timed_words(json::Element element, const json::Path& path,
                                        json::Faults& faults);
/// The way back. \throws ArgumentError, beginning with `where`, for an infinite number
nlohmann::ordered_json timed_words_json(std::span<const TimedWord> words, std::string_view where);

/// Finds ids that two records have.
class Once {
 public:
  /// \param code  of the fault: "repeated-id"
  explicit Once(std::string code) : code_(std::move(code)) {}
  void check(const std::string& id, std::size_t record, const json::Path& path,
             json::Faults& faults);

 private:
  std::string code_;
  std::unordered_map<std::string, std::size_t> places_;
};

/// Reports a part of a file of more than it may have. \param most  bytes
void refuse_large(std::size_t bytes, const json::Path& path, json::Faults& faults,
                  std::size_t most = kMostRecordBytes);

/// Reads each member of an object in turn; after kMostFaultsKept errors the rest is not read.
/// `read(members, path)` is called for each. \throws InvalidInput if the text is not JSON
template <class Read>
void for_each_member(std::string_view text, json::Faults& faults, const Read& read) {
  json::Members members(text, faults.file());
  const json::Path root;
  if (!members.is_object(faults)) return;
  while (members.next()) {
    const json::Path path(root, members.key());
    if (faults.full()) {
      faults.stop(path);
      return;
    }
    read(members, path);
  }
}

// Goes through the records that are left. \param any  whether there was one
template <class Read>
void go_through(json::Records& records, json::Faults& faults, bool& any, const Read& read) {
  const json::Path root;
  while (records.next()) {
    any = true;
    const json::Path path(root, records.index());
    if (faults.full()) {
      faults.stop(path);
      return;
    }
    if (records.element()) {
      read(&*records.element(), path);
      continue;
    }
    refuse_large(records.bytes(), path, faults);
    read(nullptr, path);
  }
}

inline void refuse_empty(json::Faults& faults) {
  faults.error(json::Path(), "not-json",
               "the file is empty; a list, or lines of JSON, are expected");
}

template <class Read>
void for_each_record(std::string_view text, json::Faults& faults, const Read& read) {
  json::Records records(text, faults.file(), kMostRecordBytes);
  bool any = false;
  go_through(records, faults, any, [&](const json::Element* element, const json::Path& path) {
    if (element != nullptr) read(*element, path);
  });
  if (!any && records.is_lines()) refuse_empty(faults);
}

// Results of a part of a file.
template <class Value>
struct PartRead {
  explicit PartRead(const std::string& file) : faults(file) {}
  std::vector<Value> values;
  json::Faults faults;
  std::exception_ptr failure;
  bool any = false;
};

// Reads part k, or a list whole.
template <class Value, class Read>
void read_part(std::string_view text, const json::Parts& split, std::size_t k,
               PartRead<Value>& part, const Read& read) {
  const std::string& file = part.faults.file();
  std::optional<json::Records> records;
  if (split.is_lines) {
    records.emplace(split.texts[k], file, kMostRecordBytes, split.begins[k]);
  } else {
    records.emplace(text, file, kMostRecordBytes);
  }
  go_through(*records, part.faults, part.any,
             [&](const json::Element* element, const json::Path& path) {
               if (element != nullptr) {
                 part.values.push_back(read(*element, path, part.faults));
               } else {
                 part.values.emplace_back();
               }
             });
}

// In their order, up to where one thread would have stopped.
template <class Value>
std::vector<Value> join_parts(const json::Parts& split, std::vector<PartRead<Value>>& parts,
                              json::Faults& faults) {
  std::vector<Value> values;
  bool any = !split.is_lines;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    PartRead<Value>& part = parts[k];
    if (faults.full()) {
      faults.stop(json::Path(json::Path(), split.begins[k].record));
      break;
    }
    if (part.failure) std::rethrow_exception(part.failure);
    faults.append(std::move(part.faults));
    any = any || part.any;
    if (values.empty()) {
      values = std::move(part.values);
    } else {
      std::move(part.values.begin(), part.values.end(), std::back_inserter(values));
    }
  }
  if (!any) refuse_empty(faults);
  return values;
}

template <class Value, class Read>
std::vector<Value> read_in_parallel(std::string_view text, json::Faults& faults, const Read& read) {
  constexpr std::size_t kPartBytes = std::size_t{1} << 22U;
  const json::Parts split = json::split_records(text, kPartBytes);
  std::vector<PartRead<Value>> parts(split.texts.size(), PartRead<Value>(faults.file()));
  parallel_for(parts.size(), 1, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      try {
        read_part(text, split, k, parts[k], read);
      } catch (...) {  // of several, the first in the file counts
        parts[k].failure = std::current_exception();
      }
    }
  });
  return join_parts(split, parts, faults);
}

}  // namespace enfilade::tasks::formats
