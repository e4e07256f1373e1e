#include "enfilade/tasks/formats/object_lines.h"

#include <fmt/format.h>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <unordered_map>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/numbers.h"
#include "enfilade/tasks/formats/r2r_entries.h"
#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks::formats {
namespace {

using json::Element;
using json::Faults;
using json::Path;

enum Wanted : std::size_t {
  kId,
  kScan,
  kPath,
  kSeenFrom,
  kObject,
  kText,
  kTokens,
  kHeading,
  kFields
};
constexpr std::array<json::Field, kFields> kWanted{{{"instr_id"},
                                                    {"scan"},
                                                    {"path"},
                                                    {"pos_vps"},
                                                    {"objid"},
                                                    {"instruction", false},
                                                    {"instr_encoding", false},
                                                    {"heading", false}}};

// 17 or "17".
std::int64_t read_object(Element element, const Path& path, Faults& faults) {
  if (element.is_string()) {
    const std::string_view text = json::string(element, path, faults).value_or("");
    const auto number = parse_number<std::int64_t>(text);
    if (number && *number >= 0 && fmt::to_string(*number) == text) return *number;
    faults.error(path, "wrong-id", fmt::format("{:?}, not the number of an object", text));
    return 0;
  }
  const auto number = json::integer(element, path, faults);
  if (number && *number < 0) {
    faults.error(path, "negative-id", fmt::format("{} is no id; 0 and more are", *number));
  }
  return number.value_or(0);
}

NamedObject read_goal(Element object, Element viewpoints, const Path& path, Faults& faults) {
  NamedObject goal{read_object(object, Path(path, "objid"), faults)};
  const Path place(path, "pos_vps");
  const std::size_t errors = faults.errors();
  goal.seen_from = json::strings(viewpoints, place, faults);
  if (goal.seen_from.empty() && faults.errors() == errors) {
    faults.error(place, "unseen-object", "no viewpoint that sees the object; one is expected");
  }
  return goal;
}

class RecordReader {
 public:
  PathAnnotation read(Element element, std::size_t record, const Path& path, Faults& faults) {
    PathAnnotation entry;
    std::array<std::optional<Element>, kFields> found;
    if (!json::fields(element, kWanted, found, path, faults)) return entry;
    InstructionDetails& details = entry.details.emplace_back();
    entry.instructions.emplace_back();
    read_id(*found[kId], record, entry, Path(path, "instr_id"), faults);
    entry.scan = json::string(*found[kScan], Path(path, "scan"), faults).value_or("");
    entry.path = read_path(*found[kPath], Path(path, "path"), faults);
    entry.goal = read_goal(*found[kObject], *found[kSeenFrom], path, faults);
    if (found[kText]) {
      entry.instructions[0] =
          json::string(*found[kText], Path(path, "instruction"), faults).value_or("");
    }
    if (found[kTokens]) {
      details.tokens = read_tokens(*found[kTokens], Path(path, "instr_encoding"), faults);
    }
    if (found[kHeading]) {
      entry.heading = read_angle(*found[kHeading], Path(path, "heading"), faults);
    }
    return entry;
  }

 private:
  void read_id(Element element, std::size_t record, PathAnnotation& entry, const Path& path,
               Faults& faults) {
    entry.path_id = static_cast<std::int64_t>(record);
    const auto id = json::string(element, path, faults);
    if (!id) return;
    if (id->empty()) {
      faults.error(path, "bad-instruction-id", "an empty text, not the instruction's id");
      return;
    }
    entry.id = *id;
    entry.details[0].id = *id;
    ids_.check(entry.id, record, path, faults);
    const std::string group = entry.id.substr(0, entry.id.rfind('_'));
    entry.group = groups_.emplace(group, entry.path_id).first->second;
  }

  Once ids_{"repeated-id"};
  std::unordered_map<std::string, std::int64_t> groups_;
};

nlohmann::ordered_json fields_of(const PathAnnotation& entry) {
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
  return lines_of_entries(annotations, fields_of);
}

}  // namespace enfilade::tasks::formats
