#include "enfilade/service/browsing/site_json.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/numbers.h"
#include "enfilade/draw/outlines.h"
#include "enfilade/draw/planned_goal.h"
#include "enfilade/service/detail/goal_kinds.h"
#include "enfilade/service/detail/json_list.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/pose_trace.h"

namespace enfilade::service::browsing {
namespace {

using nlohmann::ordered_json;

ordered_json turn_json(const tasks::DialogueTurn& turn) {
  return {{"role", turn.role}, {"message", turn.message}, {"nav_step", turn.nav_step}};
}

ordered_json word_json(const tasks::TimedWord& word) {
  ordered_json one{{"word", word.word}};
  if (word.start) one["start"] = *word.start;
  if (word.end) one["end"] = *word.end;
  return one;
}

ordered_json part_json(const tasks::SubInstruction& part) {
  ordered_json one{{"words", part.words}};
  if (part.places) one["places"] = {part.places->first, part.places->second};
  return one;
}

using detail::rounded;  // radians to a thousandth of a degree

void append_outlines(const graph::NavGraph& graph, const tasks::Goal& goal,
                     const std::vector<ViewpointIndex>& viewpoints,
                     const tasks::ObjectBoxes* objects, const std::string& name,
                     ordered_json& list) {
  for (const ViewpointIndex v : viewpoints) {
    for (const draw::Outline& outline : draw::goal_outlines(graph, goal, v, objects)) {
      auto rim = ordered_json::array();
      for (const Vec3d& one : outline.rim) {
        const tasks::Direction at = draw::direction_of(one);
        rim.push_back(rounded(at.heading.value));
        rim.push_back(rounded(at.elevation.value));
      }
      list.push_back({{"viewpoint", graph.id(v)},
                      {"label", outline.label.empty() ? name : outline.label},
                      {"rim", rim}});
    }
  }
}

// Looks of a guide, at most 20 a second, in lists of one length. Seconds, ids, radians.
ordered_json trace_json(const tasks::PoseTrace& trace) {
  constexpr double kLeast = 0.05;  // seconds
  ordered_json times = ordered_json::array(), viewpoints = times, headings = times,
               elevations = times;
  for (std::size_t k = 0; k < trace.snapshots.size(); ++k) {
    const tasks::PoseSnapshot& one = trace.snapshots[k];
    const bool moved = viewpoints.empty() || viewpoints.back() != one.viewpoint;
    const bool last = k + 1 == trace.snapshots.size();
    if (!moved && !last && one.time - times.back().get<double>() < kLeast) continue;
    const tasks::CameraLook look = tasks::look_of(one);
    times.push_back(std::round(one.time * 1e3) / 1e3);
    viewpoints.push_back(one.viewpoint);
    headings.push_back(rounded(look.heading.value));
    elevations.push_back(rounded(look.elevation.value));
  }
  return {{"times", times},
          {"viewpoints", viewpoints},
          {"headings", headings},
          {"elevations", elevations}};
}

// The guide's trace of an instruction of RxR, in the folder of its annotations as the data set is
// unpacked, or without its split's folder. Empty: there is none.
std::filesystem::path trace_file(const PublicSplit& split, const std::string& instruction_id) {
  const std::string number = instruction_id.substr(instruction_id.rfind('_') + 1);
  const auto id = parse_number<std::int64_t>(number);
  if (!id) return {};
  const std::string name = tasks::pose_trace_name(tasks::TraceRole::kGuide, *id);
  const auto folder = std::filesystem::path(split.annotations.file).parent_path() / "pose_traces";
  std::error_code code;
  for (const auto& file : {folder / ("rxr_" + split.annotations.split) / name, folder / name}) {
    if (std::filesystem::is_regular_file(file, code)) return file;
  }
  return {};
}

// A broken trace is reported, and does not change the episode.
void add_trace(const PublicSplit& split, ordered_json& episode) {
  const auto file = trace_file(split, episode.at("instruction_id").get<std::string>());
  if (file.empty()) return;
  try {
    episode["trace"] = trace_json(tasks::load_pose_trace(file));
  } catch (const Error&) {
    episode["trace_problem"] = "the pose trace of this instruction cannot be read";
  }
}

ordered_json goal_json(const tasks::EpisodeSet& episodes, const tasks::ObjectBoxes* objects) {
  const tasks::Episode& episode = episodes.episodes.front();
  const tasks::ReferencePath& path = episodes.path_of(episode);
  const graph::NavGraph& graph = episodes.graph_of(episode);
  const std::string name = draw::name_of_goal(episodes, episode, objects);
  ordered_json goal{{"kind", detail::name_of_kind(path.goal)}};
  if (!name.empty()) goal["name"] = name;
  if (const auto* object = std::get_if<tasks::SeenObject>(&path.goal)) goal["object"] = object->id;
  const auto planned = draw::planned_goal(path, name);
  if (!planned) return goal;
  auto& viewpoints = goal["viewpoints"] = ordered_json::array();
  for (const ViewpointIndex v : planned->viewpoints) viewpoints.push_back(graph.id(v));
  append_outlines(graph, path.goal, planned->viewpoints, objects, name,
                  goal["outlines"] = ordered_json::array());
  return goal;
}

// The path and its one instruction k, looked up.
tasks::EpisodeSet looked_up(const Site& site, const PublicSplit& split,
                            const tasks::PathAnnotation& path, std::size_t k,
                            const tasks::ObjectBoxes* objects) {
  const tasks::Annotations one{
      split.annotations.split, split.annotations.file, {path}, split.annotations.task};
  tasks::EpisodeSet set;
  set.split = one.split;
  set.graphs = site.shared_graphs();
  set.paths = tasks::look_up_paths(one, site.graphs(), objects);
  set.task = one.task;
  set.episodes.push_back({tasks::instruction_id(path, k), 0, k, path.instructions[k],
                          k < path.details.size() ? path.details[k] : tasks::InstructionDetails()});
  return set;
}

// An instruction as lists of episodes have it: id, path, text, language.
ordered_json brief_episode_json(const tasks::PathAnnotation& path, std::size_t k) {
  ordered_json one{{"instruction_id", tasks::instruction_id(path, k)},
                   {"path_id", path.path_id},
                   {"scan", path.scan},
                   {"heading", path.heading.value},
                   {"instruction", path.instructions[k]},
                   {"start", path.path.front()}};
  if (!path.goal_hidden()) {
    one["path"] = path.path;
    if (path.distance) one["distance"] = *path.distance;
  }
  if (k < path.details.size() && !path.details[k].language.empty()) {
    one["language"] = path.details[k].language;
  }
  return one;
}

// All instructions of a path, in file order. RxR's and HAMT's files have an entry for each. Entries
// are compared only where goals are open.
ordered_json instructions_json(const PublicSplit& split, const tasks::PathAnnotation& path) {
  auto list = ordered_json::array();
  for (const tasks::PathAnnotation& other : split.annotations.paths) {
    const bool same = &other == &path || (!path.goal_hidden() && other.scan == path.scan &&
                                          other.path == path.path && other.goal == path.goal);
    for (std::size_t k = 0; same && k < other.instructions.size(); ++k) {
      ordered_json one{{"instruction_id", tasks::instruction_id(other, k)},
                       {"instruction", other.instructions[k]}};
      if (k < other.details.size() && !other.details[k].language.empty()) {
        one["language"] = other.details[k].language;
      }
      list.push_back(std::move(one));
    }
  }
  return list;
}

// Those of fine-grained R2R, where the annotations themselves have none.
void add_pieces(const Pieces::Found& found, ordered_json& episode) {
  if (found.broken) {
    episode["parts_problem"] = "the pieces of this split's instructions cannot be read";
  } else if (!found.parts.empty() && !episode.contains("parts")) {
    episode["parts"] = detail::json_list(found.parts, part_json);
  }
}

// The same with all instructions of the path, `trace` and `goal`. It also has the dialogue's turns,
// timed words, pieces and named parts, as far as there are any. `trace` has a guide's views in time
// (RxR), if its file is in the folder pose_traces/ beside the annotations (`trace_problem` if that
// cannot be read). Trace, goal and the pieces' places are absent if goals are hidden.
//
// A goal is {"kind": "end" | "turning_point" | "object" | "region" | "boxes", "name",
// "viewpoints", "outlines"}. An outline is {"viewpoint", "label", "rim"}: headings and elevations
// alternating, radians, of a closed line around the goal's object.
// \pre path is one of the split's, which is one of the site's
ordered_json whole_episode_json(const Site& site, Pieces& pieces, const PublicSplit& split,
                                const tasks::PathAnnotation& path, std::size_t k) {
  ordered_json one = brief_episode_json(path, k);
  one["task"] = tasks::benchmark(split.annotations.task).name;
  one["instructions"] = instructions_json(split, path);
  if (k < path.details.size()) {
    const tasks::InstructionDetails& details = path.details[k];
    if (!details.turns.empty()) one["turns"] = detail::json_list(details.turns, turn_json);
    if (!details.words.empty()) one["words"] = detail::json_list(details.words, word_json);
    if (!details.parts.empty()) one["parts"] = detail::json_list(details.parts, part_json);
    for (const auto& [name, text] : details.fields) one["fields"][name] = text;
  }
  if (path.goal_hidden()) return one;
  add_pieces(pieces.of(split, path, k), one);
  const tasks::ObjectBoxes* objects =
      split.annotations.task == tasks::Task::kReverie ? site.objects() : nullptr;
  if (split.annotations.task == tasks::Task::kRxr) add_trace(split, one);
  one["goal"] = goal_json(looked_up(site, split, path, k, objects), objects);
  return one;
}

// Calls `visit` with the path and the number of each instruction of a split, in file order.
template <class Visit>
void for_each_instruction(const PublicSplit& split, const Visit& visit) {
  for (const tasks::PathAnnotation& path : split.annotations.paths) {
    for (std::size_t k = 0; k < path.instructions.size(); ++k) visit(path, k);
  }
}

// An instruction of a split; without a path: none.
struct Place {
  const tasks::PathAnnotation* path = nullptr;
  std::size_t k = 0;
};

// An instruction, and where it stands in the list of a filter's scan and words.
struct Listed {
  Place it, previous, next;
  std::int64_t number = 0;  // from 1; 0: the filter does not list it
  std::int64_t of = 0;
};

Listed find(const PublicSplit& split, const EpisodeFilter& filter) {
  Listed found;
  Place last;
  for_each_instruction(split, [&](const tasks::PathAnnotation& path, std::size_t k) {
    const bool here = found.it.path == nullptr && tasks::instruction_id(path, k) == filter.id;
    if (here) found.it = {&path, k};
    if (!filter.lists(path.scan, path.instructions[k])) return;
    ++found.of;
    if (here) {
      found.number = found.of;
      found.previous = last;
    } else if (found.number > 0 && found.of == found.number + 1) {
      found.next = {&path, k};
    }
    last = {&path, k};
  });
  return found;
}

// All that is known of an episode, and its neighbours by id.
ordered_json listed_episode_json(const Site& site, Pieces& pieces, const PublicSplit& split,
                                 const Listed& found) {
  ordered_json one = whole_episode_json(site, pieces, split, *found.it.path, found.it.k);
  if (found.number == 0) return one;
  one["number"] = found.number;
  one["of"] = found.of;
  for (const auto& [name, place] :
       {std::pair{"previous", found.previous}, std::pair{"next", found.next}}) {
    if (place.path != nullptr) one[name] = tasks::instruction_id(*place.path, place.k);
  }
  return one;
}

}  // namespace

bool EpisodeFilter::lists(std::string_view of_scan, std::string_view instruction) const {
  const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
  return (scan.empty() || scan == of_scan) &&
         (words.empty() || !std::ranges::search(instruction, words, {}, lower, lower).empty());
}

ordered_json episodes_json(const Site& site, Pieces& pieces, const PublicSplit& split,
                           const EpisodeFilter& filter) {
  std::int64_t matching = 0;
  auto list = ordered_json::array();
  if (!filter.id.empty()) {
    if (const Listed found = find(split, filter); found.it.path != nullptr) {
      ++matching;
      list.push_back(listed_episode_json(site, pieces, split, found));
    }
  } else {
    for_each_instruction(split, [&](const tasks::PathAnnotation& path, std::size_t k) {
      if (!filter.lists(path.scan, path.instructions[k])) return;
      if (filter.shows(matching++)) list.push_back(brief_episode_json(path, k));
    });
  }
  return {{"split", split.annotations.split},
          {"task", tasks::benchmark(split.annotations.task).name},
          {"title", tasks::benchmark(split.annotations.task).title},
          {"goals_hidden", split.goals_hidden},
          {"matching", matching},
          {"episodes", list}};
}

}  // namespace enfilade::service::browsing
