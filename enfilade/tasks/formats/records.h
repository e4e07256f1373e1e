/// \file  What readers of annotations share. Internal, as it includes simdjson.
#pragma once
#include <cstdint>
#include <string>
#include <unordered_map>
#include <vector>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/detail/json_records.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Of a record: the longest real ones, RxR's with their timed words, have some 30 kB.
inline constexpr std::size_t kMostRecordBytes = std::size_t{1} << 22U;

/// Reads each record of a list or of lines; one that is too large is a fault ("too-large"), and
/// after kMostFaultsKept errors the rest is not read. `read(element, path)` is called for the
/// others. \throws InvalidInput if the text is not JSON
template <class Read>
void for_each_record(std::string_view text, json::Faults& faults, const Read& read);

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

template <class Read>
void for_each_record(std::string_view text, json::Faults& faults, const Read& read) {
  json::Records records(text, faults.file(), kMostRecordBytes);
  const json::Path root;
  bool any = false;
  while (records.next()) {
    any = true;
    const json::Path path(root, records.index());
    if (faults.full()) {
      faults.stop(path);
      return;
    }
    if (records.element()) {
      read(*records.element(), path);
    } else {
      faults.error(path, "too-large",
                   std::to_string(records.bytes()) + " bytes; " + std::to_string(kMostRecordBytes) +
                       " are allowed");
    }
  }
  if (!any && records.is_lines()) {
    faults.error(root, "not-json", "the file is empty; a list, or lines of JSON, are expected");
  }
}

}  // namespace enfilade::tasks::formats
