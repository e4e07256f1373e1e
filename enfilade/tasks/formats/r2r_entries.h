/// \file  Entries as R2R's files have them, read and written for all formats that add fields to
/// them. Internal, as it includes simdjson.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <unordered_map>

#include "enfilade/core/detail/json.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks::formats {

/// Reads `path_id`, `scan`, `heading`, `path`, `instructions`, and an optional `distance`. Fields
/// of other names are left to the caller. A `path_id` that is a text, as in files from other
/// buildings than Matterport3D's, becomes the entry's id; then its number is `record`.
PathAnnotation read_r2r_entry(json::Element element, std::size_t record, const json::Path& path,
                              json::Faults& faults);

/// Finds path_ids that two entries have.
class PathIds {
 public:
  /// \param record  its place in the file  \param path  of the entry
  void check(const PathAnnotation& entry, std::size_t record, const json::Path& path,
             json::Faults& faults);

 private:
  std::unordered_map<std::int64_t, std::size_t> numbers_;
  std::unordered_map<std::string, std::size_t> texts_;
};

/// Reads what stands in an entry beside the fields of read_r2r_entry().
/// \param complete  whether those could be read, so that others can be compared with them
using ReadMore = std::function<void(json::Element element, bool complete, PathAnnotation& entry,
                                    const json::Path& path, json::Faults& faults)>;
/// read_r2r_entry(), further fields, and a check whether `ids` has its path_id.
PathAnnotation read_entry(json::Element element, std::size_t record, const ReadMore& read_more,
                          PathIds& ids, const json::Path& path, json::Faults& faults);

/// `instr_encodings`: a list of token ids for each of the instructions, into the entry's details.
/// \param complete  as above
void read_encodings(json::Element element, bool complete, PathAnnotation& entry,
                    const json::Path& path, json::Faults& faults);

/// Reads a record of a file. \param record  its number, from 0
using ReadRecord = std::function<PathAnnotation(json::Element element, std::size_t record,
                                                const json::Path& path, json::Faults& faults)>;
/// A list, or lines. \throws InvalidInput listing its faults
Annotations read_records(std::string_view text, const std::string& file, std::string split,
                         Task task, const ReadRecord& read_record);

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
