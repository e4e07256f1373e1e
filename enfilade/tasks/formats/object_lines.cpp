#include "enfilade/tasks/formats/readers.h"

#include <fmt/format.h>
#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <unordered_map>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/numbers.h"
#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks::formats {
namespace {

// 17 or "17".
std::int64_t read_object(Element element, const Path& path, Faults& faults) {
  if (element.is_string()) {
    const std::string_view text = json::string(element, path, faults).value_or("");
    const auto number = parse_number<std::int64_t>(text);
    if (number && *number >= 0 && fmt::to_string(*number) == text) return *number;
    faults.error(path, "wrong-id", quote(text) + ", not the number of an object");
    return 0;
  }
  return read_number(element, path, faults).value_or(0);
}

NamedObject read_goal(const Fields& found, Faults& faults) {
  NamedObject goal{found.get("objid", read_object)};
  const std::size_t errors = faults.errors();
  goal.seen_from = found.get("pos_vps", json::ids);
  if (goal.seen_from.empty() && faults.errors() == errors) {
    faults.error(found.place("pos_vps"), "unseen-object",
                 "no viewpoint that sees the object; one is expected");
  }
  return goal;
}

class RecordReader {
 public:
  PathAnnotation read(Element element, std::size_t record, const Path& path, Faults& faults) {
    PathAnnotation entry;
    const Fields found(element, {"instr_id", "scan", "path", "pos_vps", "objid"},
                       {"instruction", "instr_encoding", "heading"}, path, faults);
    if (!found) return entry;
    InstructionDetails& details = entry.details.emplace_back();
    entry.instructions.emplace_back();
    read_id(*found["instr_id"], record, entry, found.place("instr_id"), faults);
    entry.scan = found.id("scan");
    entry.path = found.get("path", read_path);
    entry.goal = read_goal(found, faults);
    entry.instructions[0] = found.text("instruction");
    details.tokens = found.get("instr_encoding", read_tokens);
    entry.heading = found.get("heading", read_angle);
    return entry;
  }

 private:
  void read_id(Element element, std::size_t record, PathAnnotation& entry, const Path& path,
               Faults& faults) {
    entry.path_id = static_cast<std::int64_t>(record);
    const auto id = json::id(element, path, faults, kLongestInstructionId);
    if (!id) return;
    entry.id = *id;
    entry.details[0].id = *id;
    ids_.check(entry.id, record, path, faults);
    const std::string group = entry.id.substr(0, entry.id.rfind('_'));
    entry.group = groups_.emplace(group, entry.path_id).first->second;
  }

  Once ids_;
  std::unordered_map<std::string, std::int64_t> groups_;
};

nlohmann::ordered_json object_fields(const PathAnnotation& entry) {
  const auto* goal = std::get_if<NamedObject>(&entry.goal);
  if (goal == nullptr || goal->seen_from.empty() || entry.instructions.size() != 1 ||
      entry.details.size() != 1) {
    throw ArgumentError(
        fmt::format("path {}: not one instruction to find an object with viewpoints that see it",
                    entry.path_id));
  }
  if (entry.details[0].id.empty() || entry.path.empty() || goal->id < 0) {
    throw ArgumentError(
        fmt::format("path {}: no id of its instruction, no viewpoint, or a negative object id, {}",
                    entry.path_id, goal->id));
  }
  if (!std::isfinite(entry.heading.value)) {
    throw ArgumentError(fmt::format("path {}: a heading of {}, not a finite number", entry.path_id,
                                    entry.heading.value));
  }
  const InstructionDetails& details = entry.details[0];
  nlohmann::ordered_json fields{{"instr_id", details.id},
                                {"scan", entry.scan},
                                {"path", entry.path},
                                {"heading", entry.heading.value},
                                {"pos_vps", goal->seen_from},
                                {"objid", goal->id},
                                {"instruction", entry.instructions[0]}};
  if (!details.tokens.empty()) fields["instr_encoding"] = details.tokens;
  return fields;
}

}  // namespace

Annotations parse_object_lines(std::string_view text, const std::string& file, std::string split) {
  RecordReader reader;
  return read_records(text, file, std::move(split), Task::kReverie,
                      [&](Element element, std::size_t record, const Path& path, Faults& faults) {
                        return reader.read(element, record, path, faults);
                      });
}

std::string to_object_lines(const Annotations& annotations) {
  return lines_of_entries(annotations, object_fields);
}

}  // namespace enfilade::tasks::formats
