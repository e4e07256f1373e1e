#include "enfilade/tasks/formats/readers.h"

#include <fmt/format.h>
#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <variant>

#include "enfilade/core/names.h"
#include "enfilade/core/numbers.h"
#include "enfilade/tasks/formats/records.h"

namespace enfilade::tasks::formats {
namespace {

DialogueTurn read_turn(Element element, const Path& path, Faults& faults) {
  DialogueTurn turn;
  const Fields found(element, {"role", "message", "nav_idx"}, {}, path, faults);
  if (!found) return turn;
  if (const auto text = found.get("role", json::string)) {
    turn.role = *text;
    if (turn.role != "navigator" && turn.role != "oracle") {
      faults.error(found.place("role"), "unknown-role",
                   quote(turn.role) + ", neither \"navigator\" nor \"oracle\"");
    }
  }
  turn.message = found.text("message");
  turn.nav_step = found.get("nav_idx", json::integer).value_or(0);
  if (turn.nav_step < 0) {
    faults.error(found.place("nav_idx"), "bad-step",
                 fmt::format("{} is no number of steps; 0 and more are", turn.nav_step));
  }
  return turn;
}

std::vector<DialogueTurn> read_turns(Element element, const Path& path, Faults& faults) {
  std::vector<DialogueTurn> turns;
  const auto list = json::array(element, path, faults);
  if (!list) return turns;
  for (const Element one : *list) turns.push_back(read_turn(one, Path(path, turns.size()), faults));
  return turns;
}

std::string text_of(const std::vector<DialogueTurn>& turns, const std::string& target) {
  std::string text;
  for (const DialogueTurn& turn : turns) {
    text += turn.role == "navigator" ? "<NAV> " : "<ORA> ";
    text += turn.message + " ";
  }
  return text + "<TAR> " + target;
}

std::vector<std::string> read_ends(Element element, const Path& path, Faults& faults) {
  const std::size_t errors = faults.errors();
  std::vector<std::string> ends = json::ids(element, path, faults);
  if (ends.empty() && faults.errors() == errors) {
    faults.error(path, "empty-region", "no viewpoint; one at least is expected");
  }
  return ends;
}

void check_start(const std::vector<std::string>& walk, std::size_t at, const std::string& start,
                 const Path& path, Faults& faults) {
  if (at >= walk.size() || walk[at] == start) return;
  faults.error(Path(path, at), "other-start",
               fmt::format("{}, not {}, the start", quote(walk[at]), quote(start)));
}

// A path of the named field, from the start on. Instances with a region have both.
std::vector<std::string> read_walk(const Fields& found, std::string_view field,
                                   const std::string& start, const Path& path, Faults& faults) {
  if (!found.has(field)) {
    faults.error(path, "missing-field",
                 fmt::format("has \"end_panos\", but no field {}", quote(field)));
    return {};
  }
  const std::size_t errors = faults.errors();
  std::vector<std::string> walk = found.get(field, read_path);
  if (faults.errors() == errors) check_start(walk, 0, start, found.place(field), faults);
  return walk;
}

// The player is trusted who passed where the oracle pointed to.
const std::vector<std::string>& trusted(const NamedRegion& region) {
  const auto& player = region.player;
  if (player.empty() || region.planner.empty()) return player;
  const auto end = std::find(player.begin() + 1, player.end(), region.planner.back());
  return end == player.end() ? region.planner : player;
}

void read_goal(const Fields& found, const Path& path, Faults& faults, std::string target,
               PathAnnotation& entry) {
  const std::string start = entry.path[0];
  if (found.has("end_panos")) {
    NamedRegion region{std::move(target), {}, {}, {}};
    region.viewpoints = found.get("end_panos", read_ends);
    region.player = read_walk(found, "player_path", start, path, faults);
    region.planner = read_walk(found, "planner_path", start, path, faults);
    entry.path = trusted(region);
    entry.goal = std::move(region);
    return;
  }
  entry.goal = HiddenGoal{};
  for (const std::string_view field : {"player_path", "planner_path"}) {
    if (!found.has(field)) continue;
    faults.error(path, "missing-field",
                 fmt::format("has {}, but no field \"end_panos\"", quote(field)));
  }
}

PathAnnotation read_instance(Element element, std::size_t /*record*/, const Path& path,
                             Faults& faults) {
  PathAnnotation entry;
  const Fields found(element, {"inst_idx", "scan", "target", "start_pano", "dialog_history"},
                     {"game_idx", "end_panos", "player_path", "planner_path"}, path, faults);
  if (!found) return entry;
  entry.path_id = found.get("inst_idx", read_number).value_or(0);
  entry.id = fmt::to_string(entry.path_id);
  entry.scan = found.id("scan");
  std::string target = found.text("target");
  InstructionDetails& details = entry.details.emplace_back();
  details.id = entry.id;
  details.turns = found.get("dialog_history", read_turns);
  entry.instructions.push_back(text_of(details.turns, target));
  entry.group = found.get("game_idx", read_number);
  const Path place = found.place("start_pano");
  const Fields start(*found["start_pano"], {"pano", "heading"}, {}, place, faults);
  if (!start) return entry;
  entry.heading = start.get("heading", read_angle);
  std::string viewpoint = start.id("pano");
  if (viewpoint.empty()) return entry;
  entry.path.push_back(std::move(viewpoint));
  read_goal(found, path, faults, std::move(target), entry);
  return entry;
}

void read_steps(const Fields& found, const Path& path, Faults& faults, PathAnnotation& entry) {
  for (const std::string_view field : {"nav_steps", "nav_idx"}) {
    if (found.has(field)) continue;
    faults.error(path, "missing-field",
                 fmt::format("has \"end_panos\", but no field {}", quote(field)));
    return;
  }
  const std::size_t errors = faults.errors();
  std::vector<std::string> steps = found.get("nav_steps", read_path);
  const auto walked = found.get("nav_idx", json::integer);
  if (faults.errors() != errors) return;
  if (*walked < 0 || static_cast<std::uint64_t>(*walked) >= steps.size()) {
    faults.error(
        found.place("nav_idx"), "bad-step",
        fmt::format("{}, not 0 to {}, a place in \"nav_steps\"", *walked, steps.size() - 1));
    return;
  }
  check_start(steps, static_cast<std::size_t>(*walked), entry.path[0], found.place("nav_steps"),
              faults);
  steps.erase(steps.begin(), steps.begin() + *walked);
  entry.path = std::move(steps);
}

PathAnnotation read_encoded(Element element, std::size_t record, const Path& path, Faults& faults) {
  PathAnnotation entry;
  const Fields found(element, {"instr_id", "scan", "start_pano", "start_heading", "instr_encoding"},
                     {"target", "end_panos", "nav_steps", "nav_idx"}, path, faults);
  if (!found) return entry;
  entry.id = found.id("instr_id", kLongestInstructionId);
  entry.path_id = parse_number<std::int64_t>(entry.id).value_or(static_cast<std::int64_t>(record));
  entry.scan = found.id("scan");
  entry.heading = found.get("start_heading", read_angle);
  entry.instructions.emplace_back();
  InstructionDetails& details = entry.details.emplace_back();
  details.id = entry.id;
  details.tokens = found.get("instr_encoding", read_tokens);
  NamedRegion region;
  region.target = found.text("target");
  std::string start = found.id("start_pano");
  if (start.empty()) return entry;
  entry.path.push_back(std::move(start));
  if (!found.has("end_panos")) {
    entry.goal = HiddenGoal{};
    return entry;
  }
  region.viewpoints = found.get("end_panos", read_ends);
  read_steps(found, path, faults, entry);
  region.player = entry.path;
  entry.goal = std::move(region);
  return entry;
}

ArgumentError not_cvdn(const PathAnnotation& entry, std::string_view why) {
  return ArgumentError(fmt::format("instance {}: {}", quote(entry.id), why));
}

// What both forms ask for. \returns the region, or nullptr for a hidden one
const NamedRegion* check_cvdn(const PathAnnotation& entry) {
  const auto* const region = std::get_if<NamedRegion>(&entry.goal);
  if (region == nullptr && !std::holds_alternative<HiddenGoal>(entry.goal)) {
    throw not_cvdn(entry, "its goal is neither hidden nor a region");
  }
  if (region != nullptr && region->viewpoints.empty()) {
    throw not_cvdn(entry, "its region has no viewpoint");
  }
  if (entry.instructions.size() != 1 || entry.details.size() != 1) {
    throw not_cvdn(entry,
                   fmt::format("{} instructions with details of {}, not one with its details",
                               entry.instructions.size(), entry.details.size()));
  }
  if (entry.path.empty() || (region == nullptr && entry.path.size() > 1)) {
    throw not_cvdn(entry, fmt::format("a path of {} viewpoints", entry.path.size()));
  }
  r2r_fields(entry);  // checks the numbers
  return region;
}

// What the text says after the turns. \throws ArgumentError if it does not begin with them
std::string target_of(const PathAnnotation& entry) {
  const std::string before = text_of(entry.details[0].turns, "");
  const std::string& text = entry.instructions[0];
  if (!text.starts_with(before)) {
    throw not_cvdn(entry, "its text does not begin with its turns, " + quote(before));
  }
  return text.substr(before.size());
}

nlohmann::ordered_json turns_json(const PathAnnotation& entry) {
  auto list = nlohmann::ordered_json::array();
  for (const DialogueTurn& turn : entry.details[0].turns) {
    if ((turn.role != "navigator" && turn.role != "oracle") || turn.nav_step < 0) {
      throw not_cvdn(entry,
                     fmt::format("a turn of {} at step {}", quote(turn.role), turn.nav_step));
    }
    list.push_back({{"nav_idx", turn.nav_step}, {"role", turn.role}, {"message", turn.message}});
  }
  return list;
}

void check_walks(const PathAnnotation& entry, const NamedRegion& region) {
  for (const auto* const walk : {&region.player, &region.planner}) {
    if (!walk->empty() && walk->front() == entry.path.front()) continue;
    throw not_cvdn(entry, "its player's or planner's path does not begin at the start");
  }
  if (trusted(region) != entry.path) throw not_cvdn(entry, "its path is not the trusted one");
}

nlohmann::ordered_json instance_json(const PathAnnotation& entry) {
  const NamedRegion* const region = check_cvdn(entry);
  if (entry.path_id < 0 || entry.id != fmt::to_string(entry.path_id) ||
      entry.details[0].id != entry.id) {
    throw not_cvdn(entry, "its ids are not its number");
  }
  const std::string target = target_of(entry);
  nlohmann::ordered_json fields{{"inst_idx", entry.path_id}, {"scan", entry.scan}};
  fields["target"] = target;
  fields["start_pano"] = {
      {"heading", entry.heading.value}, {"elevation", 0.0}, {"pano", entry.path[0]}};
  fields["nav_camera"] = nlohmann::ordered_json::array();
  fields["dialog_history"] = turns_json(entry);
  fields["nav_history"] = nlohmann::ordered_json::array();
  if (entry.group) {
    if (*entry.group < 0) throw not_cvdn(entry, "a negative number of its game");
    fields["game_idx"] = *entry.group;
  }
  if (region == nullptr) return fields;
  check_walks(entry, *region);
  if (region->target != target) {
    throw not_cvdn(entry, fmt::format("its text ends with {}, not with its region's target, {}",
                                      quote(target), quote(region->target)));
  }
  fields["end_panos"] = region->viewpoints;
  fields["player_path"] = region->player;
  fields["planner_path"] = region->planner;
  return fields;
}

nlohmann::ordered_json encoded_json(const PathAnnotation& entry) {
  const NamedRegion* const region = check_cvdn(entry);
  if (entry.id.empty() || entry.details[0].id != entry.id) {
    throw not_cvdn(entry, "no id, or another one of its instruction");
  }
  if (!entry.instructions[0].empty()) throw not_cvdn(entry, "a text, where others have tokens");
  nlohmann::ordered_json fields{{"instr_id", entry.id}, {"scan", entry.scan}};
  if (region != nullptr && !region->target.empty()) fields["target"] = region->target;
  fields["start_pano"] = entry.path[0];
  fields["start_heading"] = entry.heading.value;
  if (region != nullptr) {
    if (region->player != entry.path) throw not_cvdn(entry, "its path is not the player's");
    fields["end_panos"] = region->viewpoints;
    fields["nav_steps"] = entry.path;
    fields["nav_idx"] = 0;
  }
  fields["instr_encoding"] = entry.details[0].tokens;
  return fields;
}

}  // namespace

std::string to_cvdn(const Annotations& annotations) {
  const auto has_tokens_alone = [](const PathAnnotation& entry) {
    return entry.instructions.size() == 1 && entry.instructions[0].empty();
  };
  const bool encoded = !annotations.paths.empty() && has_tokens_alone(annotations.paths.front());
  return list_of_entries(annotations, encoded ? encoded_json : instance_json);
}

Annotations parse_cvdn(std::string_view json, const std::string& file, std::string split) {
  return read_records(json, file, std::move(split), Task::kCvdn, "inst_idx", read_instance);
}

Annotations parse_cvdn_encoded(std::string_view json, const std::string& file, std::string split) {
  return read_records(json, file, std::move(split), Task::kCvdn, "instr_id", read_encoded);
}

}  // namespace enfilade::tasks::formats
