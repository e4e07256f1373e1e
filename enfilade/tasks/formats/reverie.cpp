#include "enfilade/tasks/formats/readers.h"

#include <fmt/format.h>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/core/numbers.h"
#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks::formats {
namespace {

// The number that an id is; none if it is another text.
std::optional<std::int64_t> plain_number(const std::string& id) {
  const auto number = parse_number<std::int64_t>(id);
  return number && *number >= 0 && fmt::to_string(*number) == id ? number : std::nullopt;
}

void read_object_goal(const Fields& found, const Path& path, Faults& faults,
                      PathAnnotation& entry) {
  const auto object = found.get("objId", read_number);
  if (!found.has("path_id")) {
    faults.error(path, "missing-field", "has \"objId\", but no field \"path_id\"");
    return;
  }
  const auto path_id = found.get("path_id", read_number);
  if (!object || !path_id) return;
  entry.path_id = *path_id;
  entry.group = *path_id;  // several objects are at the end of one path
  entry.goal = NamedObject{*object};
  const std::string expected = fmt::format("{}_{}", *path_id, *object);
  if (entry.id.empty() || entry.id == expected || plain_number(entry.id)) return;
  faults.error(Path(path, "id"), "wrong-id",
               fmt::format("{}, not {}, its path_id and objId, nor a number", quote(entry.id),
                           quote(expected)));
}

void read_hidden_goal(const Fields& found, const Path& path, Faults& faults,
                      PathAnnotation& entry) {
  entry.goal = HiddenGoal{};
  const auto number = plain_number(entry.id);
  if (number) entry.path_id = *number;
  if (!number && !entry.id.empty()) {
    faults.error(
        Path(path, "id"), "wrong-id",
        fmt::format("{}, not the number of a path, as there is no \"objId\"", quote(entry.id)));
  }
  const auto path_id = found.get("path_id", read_number);
  if (path_id && number && *path_id != *number) {
    faults.error(found.place("path_id"), "wrong-id",
                 fmt::format("{}, not {}, its id", *path_id, *number));
  }
  if (entry.path.size() > 1) {
    faults.error(Path(path, "path"), "open-path",
                 fmt::format("{} viewpoints, not the start alone, as there is no \"objId\"",
                             entry.path.size()));
  }
}

PathAnnotation read_entry(Element element, const Path& path, Faults& faults) {
  PathAnnotation entry;
  const Fields found(element, {"id", "scan", "heading", "path", "instructions"},
                     {"path_id", "objId", "instr_encodings"}, path, faults);
  if (!found) return entry;
  entry.id = found.id("id");
  entry.scan = found.id("scan");
  entry.heading = found.get("heading", read_angle);
  entry.path = found.get("path", read_path);
  entry.instructions = found.get("instructions", json::strings);
  if (const auto& encodings = found["instr_encodings"]) {
    read_encodings(*encodings, true, entry, found.place("instr_encodings"), faults);
  }
  if (found.has("objId")) {
    read_object_goal(found, path, faults, entry);
  } else {
    read_hidden_goal(found, path, faults, entry);
  }
  return entry;
}

ArgumentError not_reverie(const PathAnnotation& entry, std::string_view why) {
  return ArgumentError(fmt::format("entry {}: {}", quote(entry.id), why));
}

// That read_entry() would give the same.
void check_reverie(const PathAnnotation& entry) {
  const auto* const object = std::get_if<NamedObject>(&entry.goal);
  if (object == nullptr && !std::holds_alternative<HiddenGoal>(entry.goal)) {
    throw not_reverie(entry, "its goal is neither hidden nor an object");
  }
  if (entry.path_id < 0 || (object != nullptr && object->id < 0)) {
    throw not_reverie(entry, "a negative id of its path or object");
  }
  const std::string id = object == nullptr ? fmt::to_string(entry.path_id)
                                           : fmt::format("{}_{}", entry.path_id, object->id);
  // Goals of a test split have its numbers.
  const bool number = object != nullptr && plain_number(entry.id);
  if (entry.id != id && !number) {
    throw not_reverie(entry, fmt::format("its id has to be {}", quote(id)));
  }
  if (entry.path.empty() || (object == nullptr && entry.path.size() > 1)) {
    throw not_reverie(entry, fmt::format("a path of {} viewpoints", entry.path.size()));
  }
  if (!entry.details.empty() && entry.details.size() != entry.instructions.size()) {
    throw not_reverie(entry, fmt::format("{} instructions with details of {}",
                                         entry.instructions.size(), entry.details.size()));
  }
}

nlohmann::ordered_json reverie_fields(const PathAnnotation& entry) {
  check_reverie(entry);
  const auto* const object = std::get_if<NamedObject>(&entry.goal);
  nlohmann::ordered_json all = r2r_fields(entry);  // checks its numbers
  nlohmann::ordered_json fields{{"id", entry.id}, {"path", entry.path}};
  if (object != nullptr) fields["objId"] = object->id;
  fields["heading"] = std::move(all["heading"]);
  fields["scan"] = entry.scan;
  if (object != nullptr) fields["path_id"] = entry.path_id;
  fields["instructions"] = entry.instructions;
  if (!entry.details.empty()) add_encodings(entry, fields);
  return fields;
}

}  // namespace

std::string to_reverie(const Annotations& annotations) {
  return list_of_entries(annotations, reverie_fields);
}

Annotations parse_reverie(std::string_view json, const std::string& file, std::string split) {
  Once once;
  return read_records(json, file, std::move(split), Task::kReverie,
                      [&](Element element, std::size_t record, const Path& path, Faults& faults) {
                        PathAnnotation entry = read_entry(element, path, faults);
                        if (!entry.id.empty()) {
                          once.check(entry.id, record, Path(path, "id"), faults);
                        }
                        return entry;
                      });
}

}  // namespace enfilade::tasks::formats
