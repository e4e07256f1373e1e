/// \file  What readers and writers of annotations share: fields, records, and entries in R2R's
/// form. Internal, as it includes simdjson.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "enfilade/core/detail/json.h"
#include "enfilade/core/detail/json_entries.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

using json::Element;
using json::Faults;
using json::Path;

/// Limit of a record; the longest real ones, RxR's with their timed words, have some 30 kB.
inline constexpr std::size_t kMostRecordBytes = std::size_t{1} << 22U;

/// The fields of an object, by their names. `if (!fields)`: a required one is missing, or one is
/// there twice; that was reported. Fields of other names are ignored.
class Fields {
 public:
  using Names = std::initializer_list<std::string_view>;

  /// \param optional  names of fields that may be missing \pre `path` and the names outlive *this
  Fields(Element element, Names required, Names optional, const Path& path, Faults& faults);
  Fields(Element element, std::span<const json::Field> wanted, const Path& path, Faults& faults);

  explicit operator bool() const noexcept { return good_; }
  /// No value: the field is absent. \pre `name` is one of the names
  const std::optional<Element>& operator[](std::string_view name) const;
  bool has(std::string_view name) const { return (*this)[name].has_value(); }
  Path place(std::string_view name) const { return {path_, name}; }

  /// `read(element, place, faults, more...)` of a field; the type's default if it is absent.
  template <class Read, class... More>
  auto get(std::string_view name, const Read& read, const More&... more) const {
    const std::optional<Element>& element = (*this)[name];
    using Value = decltype(read(*element, path_, faults_, more...));
    return element ? read(*element, place(name), faults_, more...) : Value();
  }
  /// A text; empty if it is absent, or no text, which is reported.
  std::string text(std::string_view name) const;
  /// An id (core/names.h); empty if it is absent, or no id, which is reported.
  std::string id(std::string_view name, std::size_t most = kLongestId) const;

 protected:
  static constexpr std::size_t kMost = 10;
  std::array<json::Field, kMost> wanted_;
  std::array<std::optional<Element>, kMost> found_;
  std::size_t count_ = 0;
  bool good_ = false;
  const Path& path_;
  Faults& faults_;

 private:
  void find(Element element);
};

/// A text; empty if it is none.
std::string read_text(Element element, const Path& path, Faults& faults);
/// A number from 0 on, of a path, an object or a person.
std::optional<std::int64_t> read_number(Element element, const Path& path, Faults& faults);
/// The viewpoint ids of a path, one at least.
std::vector<std::string> read_path(Element element, const Path& path, Faults& faults);
/// A number of radians within kMostRadians.
Radians read_angle(Element element, const Path& path, Faults& faults);
/// Token ids.
std::vector<std::int32_t> read_tokens(Element element, const Path& path, Faults& faults);

/// Words and when they were said: `word`, and `start_time` and `end_time` in seconds, which may be
/// absent.
std::vector<TimedWord> read_timed_words(Element element, const Path& path, Faults& faults);
/// The way back. \throws ArgumentError, beginning with `where`, for an infinite number
nlohmann::ordered_json timed_words_json(std::span<const TimedWord> words, std::string_view where);

/// Finds ids that two records have.
class Once {
 public:
  /// Reports "repeated-id".
  void check(const std::string& id, std::size_t record, const Path& path, Faults& faults);

 private:
  std::unordered_map<std::string, std::size_t> places_;
};

/// Reports a part of a file of more than it may have. \param most  bytes
void refuse_large(std::size_t bytes, const Path& path, Faults& faults,
                  std::size_t most = kMostRecordBytes);

/// Reads each member of an object in turn; after kMostFaultsKept errors the rest is not read.
/// `read(members, path)` is called for each. \throws InvalidInput if the text is not JSON
template <class Read>
void for_each_member(std::string_view text, Faults& faults, const Read& read) {
  json::Members members(text, faults.file());
  const Path root;
  if (!members.is_object(faults)) return;
  while (members.next()) {
    const Path path(root, members.key());
    if (faults.full()) {
      faults.stop(path);
      return;
    }
    read(members, path);
  }
}

// Goes through the records that are left. \param any  whether there was one
template <class Read>
void go_through(json::Records& records, Faults& faults, bool& any, const Read& read) {
  const Path root;
  while (records.next()) {
    any = true;
    const Path path(root, records.index());
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

inline void refuse_empty(Faults& faults) {
  faults.error(Path(), "not-json", "the file is empty; a list, or lines of JSON, are expected");
}

/// Reads each record of a list or of lines; `read(element, path)` is called for each. A too large
/// record is a fault ("too-large") instead. After kMostFaultsKept errors the rest is not read.
/// \throws InvalidInput if the text is not JSON
template <class Read>
void for_each_record(std::string_view text, Faults& faults, const Read& read) {
  json::Records records(text, faults.file(), kMostRecordBytes);
  bool any = false;
  go_through(records, faults, any, [&](const Element* element, const Path& path) {
    if (element != nullptr) read(*element, path);
  });
  if (!any && records.is_lines()) refuse_empty(faults);
}

/// Reads `path_id`, `scan`, `heading`, `path`, `instructions`, and an optional `distance`. Fields
/// of other names are left to the caller. A `path_id` that is a text, as in files from other
/// buildings than Matterport3D's, becomes the entry's id; then its number is `record`.
PathAnnotation read_r2r_entry(Element element, std::size_t record, const Path& path,
                              Faults& faults);

/// Finds path_ids that two entries have.
class PathIds {
 public:
  /// \param record  its place in the file  \param path  of the entry
  void check(const PathAnnotation& entry, std::size_t record, const Path& path, Faults& faults);

 private:
  std::unordered_map<std::int64_t, std::size_t> numbers_;
  std::unordered_map<std::string, std::size_t> texts_;
};

/// Reads what stands in an entry beside the fields of read_r2r_entry().
/// \param complete  whether those could be read, so that others can be compared with them
using ReadMore = std::function<void(Element element, bool complete, PathAnnotation& entry,
                                    const Path& path, Faults& faults)>;
/// read_r2r_entry(), further fields, and a check whether `ids` has its path_id.
PathAnnotation read_entry(Element element, std::size_t record, const ReadMore& read_more,
                          PathIds& ids, const Path& path, Faults& faults);

/// `instr_encodings`: a list of token ids for each of the instructions, into the entry's details.
/// \param complete  as above
void read_encodings(Element element, bool complete, PathAnnotation& entry, const Path& path,
                    Faults& faults);

/// Reads a record of a file. \param record  its number, from 0
using ReadRecord = std::function<PathAnnotation(Element element, std::size_t record,
                                                const Path& path, Faults& faults)>;
/// A list, or lines. \throws InvalidInput listing its faults
Annotations read_records(std::string_view text, const std::string& file, std::string split,
                         Task task, const ReadRecord& read_record);

/// The same, where no two records without faults may have one id.
/// \param id_field  the field of the id, for messages
Annotations read_records(std::string_view text, const std::string& file, std::string split,
                         Task task, std::string_view id_field, const ReadRecord& read_record);

/// \name Each throws ArgumentError, beginning with `where`
/// @{
double finite(double number, std::string_view where);  ///< for an infinite number
/// The text of a value; for text that is not UTF-8.
std::string dump(const nlohmann::ordered_json& value, std::string_view where);
/// @}
/// The fields of read_r2r_entry(). \throws ArgumentError for an infinite number or NaN
nlohmann::ordered_json r2r_fields(const PathAnnotation& entry);
/// Adds `instr_encodings`.
void add_encodings(const PathAnnotation& entry, nlohmann::ordered_json& fields);

/// The content of a path's line.
using FieldsOf = std::function<nlohmann::ordered_json(const PathAnnotation&)>;
/// A list with one entry per line. \throws ArgumentError for text that is not UTF-8
std::string list_of_entries(const Annotations& annotations, const FieldsOf& fields_of);
/// JSON Lines. \throws ArgumentError for text that is not UTF-8
std::string lines_of_entries(const Annotations& annotations, const FieldsOf& fields_of);

}  // namespace enfilade::tasks::formats
