#include "enfilade/tasks/formats/cvdn.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>
#include <variant>

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
  kTarget,
  kStart,
  kDialogue,
  kGame,
  kEnds,
  kPlayer,
  kPlanner,
  kFields
};
constexpr std::array<json::Field, kFields> kWanted{{{"inst_idx"},
                                                    {"scan"},
                                                    {"target"},
                                                    {"start_pano"},
                                                    {"dialog_history"},
                                                    {"game_idx", false},
                                                    {"end_panos", false},
                                                    {"player_path", false},
                                                    {"planner_path", false}}};
using Found = std::array<std::optional<Element>, kFields>;

enum OfStart : std::size_t { kStartPlace, kStartHeading, kStartFields };
constexpr std::array<json::Field, kStartFields> kOfStart{{{"pano"}, {"heading"}}};

enum Encoded : std::size_t {
  kEncodedId,
  kEncodedScan,
  kEncodedTarget,
  kEncodedStart,
  kEncodedHeading,
  kEncodedEnds,
  kSteps,
  kStep,
  kTokens,
  kEncodedFields
};
constexpr std::array<json::Field, kEncodedFields> kEncoded{{{"instr_id"},
                                                            {"scan"},
                                                            {"target", false},
                                                            {"start_pano"},
                                                            {"start_heading"},
                                                            {"end_panos", false},
                                                            {"nav_steps", false},
                                                            {"nav_idx", false},
                                                            {"instr_encoding"}}};
using FoundEncoded = std::array<std::optional<Element>, kEncodedFields>;

// The instance's id, or that of its dialogue.
std::int64_t read_id(Element element, const Path& path, Faults& faults) {
  const auto number = json::integer(element, path, faults);
  if (number && *number < 0) {
    faults.error(path, "negative-id", fmt::format("{} is no id; 0 and more are", *number));
  }
  return number.value_or(0);
}

std::string read_text(Element element, const Path& path, Faults& faults) {
  return std::string(json::string(element, path, faults).value_or(""));
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
  std::vector<std::string> ends = json::strings(element, path, faults);
  if (ends.empty() && faults.errors() == errors) {
    faults.error(path, "empty-region", "no viewpoint; one at least is expected");
  }
  return ends;
}

void check_start(const std::vector<std::string>& walk, std::size_t at, const std::string& start,
                 const Path& path, Faults& faults) {
  if (at >= walk.size() || walk[at] == start) return;
  faults.error(Path(path, at), "other-start",
               fmt::format("{:?}, not {:?}, the start", walk[at], start));
}

// A path of the named field, from the start on. Instances with a region have both.
std::vector<std::string> read_walk(const Found& found, Wanted field, const std::string& start,
                                   const Path& path, Faults& faults) {
  const std::string_view name = kWanted[field].name;
  if (!found[field]) {
    faults.error(path, "missing-field", fmt::format("has \"end_panos\", but no field {:?}", name));
    return {};
  }
  const Path place(path, name);
  const std::size_t errors = faults.errors();
  std::vector<std::string> walk = read_path(*found[field], place, faults);
  if (faults.errors() == errors) check_start(walk, 0, start, place, faults);
  return walk;
}

// The player is trusted who passed where the oracle pointed to.
const std::vector<std::string>& trusted(const NamedRegion& region) {
  const auto& player = region.player;
  if (player.empty() || region.planner.empty()) return player;
  const auto end = std::find(player.begin() + 1, player.end(), region.planner.back());
  return end == player.end() ? region.planner : player;
}

void read_goal(const Found& found, const Path& path, Faults& faults, std::string target,
               PathAnnotation& entry) {
  const std::string start = entry.path[0];
  if (found[kEnds]) {
    NamedRegion region{std::move(target), {}, {}, {}};
    region.viewpoints = read_ends(*found[kEnds], Path(path, "end_panos"), faults);
    region.player = read_walk(found, kPlayer, start, path, faults);
    region.planner = read_walk(found, kPlanner, start, path, faults);
    entry.path = trusted(region);
    entry.goal = std::move(region);
    return;
  }
  entry.goal = HiddenGoal{};
  for (const Wanted field : {kPlayer, kPlanner}) {
    if (!found[field]) continue;
    faults.error(path, "missing-field",
                 fmt::format("has {:?}, but no field \"end_panos\"", kWanted[field].name));
  }
}

PathAnnotation read_instance(Element element, const Path& path, Faults& faults) {
  PathAnnotation entry;
  Found found;
  if (!json::fields(element, kWanted, found, path, faults)) return entry;
  entry.path_id = read_id(*found[kId], Path(path, "inst_idx"), faults);
  entry.id = fmt::to_string(entry.path_id);
  entry.scan = read_text(*found[kScan], Path(path, "scan"), faults);
  std::string target = read_text(*found[kTarget], Path(path, "target"), faults);
  InstructionDetails& details = entry.details.emplace_back();
  details.id = entry.id;
  details.turns = read_turns(*found[kDialogue], Path(path, "dialog_history"), faults);
  entry.instructions.push_back(text_of(details.turns, target));
  if (found[kGame]) entry.group = read_id(*found[kGame], Path(path, "game_idx"), faults);
  const Path place(path, "start_pano");
  std::array<std::optional<Element>, kStartFields> start;
  if (!json::fields(*found[kStart], kOfStart, start, place, faults)) return entry;
  entry.heading = read_angle(*start[kStartHeading], Path(place, "heading"), faults);
  const auto viewpoint = json::string(*start[kStartPlace], Path(place, "pano"), faults);
  if (!viewpoint) return entry;
  entry.path.emplace_back(*viewpoint);
  read_goal(found, path, faults, std::move(target), entry);
  return entry;
}

void read_steps(const FoundEncoded& found, const Path& path, Faults& faults,
                PathAnnotation& entry) {
  for (const Encoded field : {kSteps, kStep}) {
    if (found[field]) continue;
    faults.error(path, "missing-field",
                 fmt::format("has \"end_panos\", but no field {:?}", kEncoded[field].name));
    return;
  }
  const Path place(path, "nav_steps"), index(path, "nav_idx");
  const std::size_t errors = faults.errors();
  std::vector<std::string> steps = read_path(*found[kSteps], place, faults);
  const auto walked = json::integer(*found[kStep], index, faults);
  if (faults.errors() != errors) return;
  if (*walked < 0 || static_cast<std::uint64_t>(*walked) >= steps.size()) {
    faults.error(
        index, "bad-step",
        fmt::format("{}, not 0 to {}, a place in \"nav_steps\"", *walked, steps.size() - 1));
    return;
  }
  check_start(steps, static_cast<std::size_t>(*walked), entry.path[0], place, faults);
  steps.erase(steps.begin(), steps.begin() + *walked);
  entry.path = std::move(steps);
}

PathAnnotation read_encoded(Element element, std::size_t record, const Path& path, Faults& faults) {
  PathAnnotation entry;
  FoundEncoded found;
  if (!json::fields(element, kEncoded, found, path, faults)) return entry;
  const Path id(path, "instr_id");
  const std::size_t errors = faults.errors();
  entry.id = read_text(*found[kEncodedId], id, faults);
  if (entry.id.empty() && faults.errors() == errors) {
    faults.error(id, "wrong-id", "an empty text, not the instance's id");
  }
  const auto number = parse_number<std::int64_t>(entry.id);
  entry.path_id = number ? *number : static_cast<std::int64_t>(record);
  entry.scan = read_text(*found[kEncodedScan], Path(path, "scan"), faults);
  entry.heading = read_angle(*found[kEncodedHeading], Path(path, "start_heading"), faults);
  entry.instructions.emplace_back();
  InstructionDetails& details = entry.details.emplace_back();
  details.id = entry.id;
  details.tokens = read_tokens(*found[kTokens], Path(path, "instr_encoding"), faults);
  NamedRegion region;
  if (found[kEncodedTarget]) {
    region.target = read_text(*found[kEncodedTarget], Path(path, "target"), faults);
  }
  const auto start = json::string(*found[kEncodedStart], Path(path, "start_pano"), faults);
  if (!start) return entry;
  entry.path.emplace_back(*start);
  if (!found[kEncodedEnds]) {
    entry.goal = HiddenGoal{};
    return entry;
  }
  region.viewpoints = read_ends(*found[kEncodedEnds], Path(path, "end_panos"), faults);
  read_steps(found, path, faults, entry);
  region.player = entry.path;
  entry.goal = std::move(region);
  return entry;
}

// \param read  gives an entry of an element, the record's number and its place
template <class Read>
Annotations read_all(std::string_view json, const std::string& file, std::string split,
                     std::string_view id_field, const Read& read) {
  Annotations result{std::move(split), file, {}, Task::kCvdn};
  Faults faults(file);
  Once once("repeated-id");
  for_each_record(json, faults, [&](Element element, const Path& path) {
    const std::size_t errors = faults.errors();
    const std::size_t record = result.paths.size();
    const PathAnnotation& entry = result.paths.emplace_back(read(element, record, path, faults));
    if (faults.errors() != errors) return;  // it may have no id
    once.check(entry.id, record, Path(path, id_field), faults);
  });
  faults.throw_if_errors();
  return result;
}

ArgumentError not_cvdn(const PathAnnotation& entry, std::string_view why) {
  return ArgumentError(fmt::format("instance {:?}: {}", entry.id, why));
}

// What both forms ask for. \returns the region, or nullptr for a hidden one
const NamedRegion* check_form(const PathAnnotation& entry) {
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
    throw not_cvdn(entry, fmt::format("its text does not begin with its turns, {:?}", before));
  }
  return text.substr(before.size());
}

nlohmann::ordered_json turns_json(const PathAnnotation& entry) {
  auto list = nlohmann::ordered_json::array();
  for (const DialogueTurn& turn : entry.details[0].turns) {
    if ((turn.role != "navigator" && turn.role != "oracle") || turn.nav_step < 0) {
      throw not_cvdn(entry, fmt::format("a turn of {:?} at step {}", turn.role, turn.nav_step));
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
  const NamedRegion* const region = check_form(entry);
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
    throw not_cvdn(entry, fmt::format("its text ends with {:?}, not with its region's target, {:?}",
                                      target, region->target));
  }
  fields["end_panos"] = region->viewpoints;
  fields["player_path"] = region->player;
  fields["planner_path"] = region->planner;
  return fields;
}

nlohmann::ordered_json encoded_json(const PathAnnotation& entry) {
  const NamedRegion* const region = check_form(entry);
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
  return read_all(json, file, std::move(split), "inst_idx",
                  [](Element element, std::size_t /*record*/, const Path& path, Faults& faults) {
                    return read_instance(element, path, faults);
                  });
}

Annotations parse_cvdn_encoded(std::string_view json, const std::string& file, std::string split) {
  return read_all(json, file, std::move(split), "instr_id", read_encoded);
}

}  // namespace enfilade::tasks::formats
