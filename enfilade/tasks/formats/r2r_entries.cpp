#include "enfilade/tasks/formats/r2r_entries.h"

#include <fmt/format.h>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks::formats {
namespace {

enum EntryField : std::size_t {
  kEntryId,
  kEntryScan,
  kEntryHeading,
  kEntryPath,
  kEntryInstructions,
  kEntryDistance,
  kEntryFields
};
constexpr std::array<json::Field, kEntryFields> kOfEntry{
    {{"path_id"}, {"scan"}, {"heading"}, {"path"}, {"instructions"}, {"distance", false}}};

void read_distance(json::Element element, PathAnnotation& entry, const json::Path& path,
                   json::Faults& faults) {
  entry.distance = json::number(element, path, faults);
  if (!entry.distance || *entry.distance >= 0) return;
  faults.error(path, "bad-distance", fmt::format("{} is no length in metres", *entry.distance));
}

void read_path_id(json::Element element, std::size_t record, const json::Path& path,
                  json::Faults& faults, PathAnnotation& entry) {
  if (!element.is_string()) {
    entry.path_id = json::integer(element, path, faults).value_or(0);
    return;
  }
  entry.id = json::string(element, path, faults).value_or("");
  entry.path_id = static_cast<std::int64_t>(record);
  if (entry.id.empty()) faults.error(path, "bad-id", "an empty text, not the path's id");
}

std::string line_of(const PathAnnotation& entry, const FieldsOf& fields_of) {
  try {
    return fields_of(entry).dump();
  } catch (const nlohmann::json::type_error&) {
    throw ArgumentError(fmt::format("path {}: holds text that is not UTF-8", entry.path_id));
  }
}

}  // namespace

PathAnnotation read_r2r_entry(json::Element element, std::size_t record, const json::Path& path,
                              json::Faults& faults) {
  PathAnnotation entry;
  std::array<std::optional<json::Element>, kEntryFields> found;
  if (!json::fields(element, kOfEntry, found, path, faults)) return entry;
  read_path_id(*found[kEntryId], record, json::Path(path, "path_id"), faults, entry);
  entry.scan = json::string(*found[kEntryScan], json::Path(path, "scan"), faults).value_or("");
  entry.heading = read_angle(*found[kEntryHeading], json::Path(path, "heading"), faults);
  entry.path = read_path(*found[kEntryPath], json::Path(path, "path"), faults);
  entry.instructions =
      json::strings(*found[kEntryInstructions], json::Path(path, "instructions"), faults);
  if (found[kEntryDistance]) {
    read_distance(*found[kEntryDistance], entry, json::Path(path, "distance"), faults);
  }
  return entry;
}

void PathIds::check(const PathAnnotation& entry, std::size_t record, const json::Path& path,
                    json::Faults& faults) {
  const bool number = entry.id.empty();
  const std::size_t first = number ? numbers_.emplace(entry.path_id, record).first->second
                                   : texts_.emplace(entry.id, record).first->second;
  if (first == record) return;
  faults.error(
      json::Path(path, "path_id"), "repeated-path-id",
      fmt::format("{} stands at $[{}] already",
                  number ? fmt::to_string(entry.path_id) : fmt::format("{:?}", entry.id), first));
}

PathAnnotation read_entry(json::Element element, std::size_t record, const ReadMore& read_more,
                          PathIds& ids, const json::Path& path, json::Faults& faults) {
  const std::size_t errors = faults.errors();
  PathAnnotation entry = read_r2r_entry(element, record, path, faults);
  const bool complete = faults.errors() == errors;
  if (element.is_object()) read_more(element, complete, entry, path, faults);
  if (complete) ids.check(entry, record, path, faults);
  return entry;
}

void read_encodings(json::Element element, bool complete, PathAnnotation& entry,
                    const json::Path& path, json::Faults& faults) {
  const auto lists = json::array(element, path, faults);
  if (!lists) return;
  const std::size_t instructions = entry.instructions.size();
  if (complete && lists->size() != instructions) {
    faults.error(path, "wrong-count",
                 fmt::format("{} lists of tokens; {} are expected, one for each instruction",
                             lists->size(), instructions));
    return;  // before memory is taken for them: a file can have many more than it has words
  }
  std::size_t k = 0;
  if (complete) entry.details.resize(instructions);
  for (const json::Element list : *lists) {
    if (faults.full()) return;
    std::vector<std::int32_t> tokens = read_tokens(list, json::Path(path, k), faults);
    if (complete) entry.details[k].tokens = std::move(tokens);
    ++k;
  }
}

Annotations read_records(std::string_view text, const std::string& file, std::string split,
                         Task task, const ReadRecord& read_record) {
  Annotations result{std::move(split), file, {}, task};
  json::Faults faults(file);
  for_each_record(text, faults, [&](json::Element element, const json::Path& path) {
    result.paths.push_back(read_record(element, result.paths.size(), path, faults));
  });
  faults.throw_if_errors();
  return result;
}

nlohmann::ordered_json r2r_fields(const PathAnnotation& entry) {
  if (!std::isfinite(entry.heading.value) || !std::isfinite(entry.distance.value_or(0))) {
    throw ArgumentError(fmt::format("path {}: heading {} and distance {}, not finite numbers",
                                    entry.path_id, entry.heading.value,
                                    entry.distance.value_or(0)));
  }
  nlohmann::ordered_json fields;
  if (entry.id.empty()) {
    fields["path_id"] = entry.path_id;
  } else {
    fields["path_id"] = entry.id;
  }
  fields.update({{"scan", entry.scan}, {"heading", entry.heading.value}, {"path", entry.path}});
  if (entry.distance) fields["distance"] = *entry.distance;
  fields["instructions"] = entry.instructions;
  return fields;
}

void add_encodings(const PathAnnotation& entry, nlohmann::ordered_json& fields) {
  auto& lists = fields["instr_encodings"] = nlohmann::ordered_json::array();
  for (const InstructionDetails& details : entry.details) lists.push_back(details.tokens);
}

std::string list_of_entries(const Annotations& annotations, const FieldsOf& fields_of) {
  std::string text = "[";
  for (const PathAnnotation& entry : annotations.paths) {
    text += text.size() == 1 ? "\n" : ",\n";
    text += line_of(entry, fields_of);
  }
  return text + "\n]\n";
}

std::string lines_of_entries(const Annotations& annotations, const FieldsOf& fields_of) {
  std::string text;
  for (const PathAnnotation& entry : annotations.paths) text += line_of(entry, fields_of) + '\n';
  return text;
}

}  // namespace enfilade::tasks::formats
