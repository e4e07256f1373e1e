// From names in files to viewpoints of graphs.
#include <fmt/format.h>
#include <algorithm>
#include <limits>
#include <map>
#include <unordered_map>
#include <utility>

#include "enfilade/core/detail/json.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/objects.h"

namespace enfilade::tasks {
namespace {

using json::Faults;
using json::Path;

// Looks up the viewpoints of one path annotation.
class LookUp {
 public:
  LookUp(const PathAnnotation& entry, const graph::NavGraph& graph, bool along_edges,
         Faults& faults)
      : entry_(entry), graph_(graph), along_edges_(along_edges), faults_(faults) {}

  // The included viewpoints of a list; others are reported.
  std::vector<ViewpointIndex> viewpoints(const std::vector<std::string>& ids, const Path& path,
                                         bool along_edges) {
    std::vector<ViewpointIndex> found;
    found.reserve(ids.size());
    std::optional<ViewpointIndex> last;
    for (std::size_t k = 0; k < ids.size(); ++k) {
      const Path place(path, k);
      const auto one = viewpoint(ids[k], place);
      if (along_edges && one && last && graph_.edge(*last, *one) == nullptr) {
        faults_.error(place, "not-adjacent",
                      fmt::format("no edge leads from {} to {} in scan {}", quote(ids[k - 1]),
                                  quote(ids[k]), entry_.scan));
      }
      last = one;
      if (one) found.push_back(*one);
    }
    return found;
  }
  std::vector<ViewpointIndex> path(const Path& place) {
    return viewpoints(entry_.path, place, along_edges_);
  }

  Goal goal(const Path& path, const ObjectBoxes* objects) {
    return std::visit([&](const auto& named) { return find(named, path, objects); }, entry_.goal);
  }

 private:
  std::optional<ViewpointIndex> viewpoint(const std::string& id, const Path& place) {
    const auto found = graph_.find(id);
    if (!found) {
      faults_.error(place, "unknown-viewpoint",
                    fmt::format("viewpoint {} is not one of the {} of scan {}", quote(id),
                                graph_.size(), entry_.scan));
    } else if (!graph_.included(*found)) {
      faults_.error(place, "excluded-viewpoint",
                    fmt::format("viewpoint {} of scan {} is excluded from its graph", quote(id),
                                entry_.scan));
      return std::nullopt;
    }
    return found;
  }

  Goal find(const NearEnd& goal, const Path& /*path*/, const ObjectBoxes* /*objects*/) {
    return entry_.path.size() < 2 ? Goal(HiddenGoal()) : Goal(goal);
  }
  Goal find(const HiddenGoal& goal, const Path& /*path*/, const ObjectBoxes* /*objects*/) {
    return goal;
  }
  Goal find(const NamedTurningPoint& goal, const Path& path, const ObjectBoxes* /*objects*/) {
    const auto turn = viewpoint(goal.viewpoint, Path(path, "midstop"));
    return TurningPoint{turn.value_or(ViewpointIndex())};
  }
  // Viewpoints that the graph leaves out see objects, too; no agent can be there.
  Goal find(const NamedObject& goal, const Path& path, const ObjectBoxes* objects) {
    SeenObject seen{goal.id, {}};
    if (!goal.seen_from.empty()) {
      seen.seen_from = viewpoints(goal.seen_from, Path(path, "pos_vps"), false);
      std::ranges::sort(seen.seen_from);
      return seen;
    }
    if (objects == nullptr) return seen;
    for (const std::string& id : objects->seen_from(entry_.scan, goal.id)) {
      const auto found = graph_.find(id);
      if (found && graph_.included(*found)) seen.seen_from.push_back(*found);
    }
    std::ranges::sort(seen.seen_from);
    if (seen.seen_from.empty()) {
      faults_.error(Path(path, "objId"), "unseen-object",
                    fmt::format("no viewpoint of scan {} sees object {}", entry_.scan, goal.id));
    }
    return seen;
  }
  Goal find(const NamedRegion& goal, const Path& path, const ObjectBoxes* /*objects*/) {
    Region region;
    region.viewpoints = viewpoints(goal.viewpoints, Path(path, "end_panos"), false);
    region.player = viewpoints(goal.player, Path(path, "player_path"), false);
    region.planner = viewpoints(goal.planner, Path(path, "planner_path"), false);
    return region;
  }
  Goal find(const NamedBoxes& goal, const Path& path, const ObjectBoxes* /*objects*/) {
    Boxes boxes;
    const Path list(path, "bboxes");
    for (std::size_t k = 0; k < goal.boxes.size(); ++k) {
      const NamedBox& named = goal.boxes[k];
      const Path place(list, k);
      if (const auto at = viewpoint(named.viewpoint, Path(place, "image_id"))) {
        boxes.boxes.push_back({*at, named.centre, named.corners, named.object});
      }
    }
    boxes.first_alternative = viewpoints(goal.first_alternative, Path(path, "path"), false);
    return boxes;
  }

  const PathAnnotation& entry_;
  const graph::NavGraph& graph_;
  bool along_edges_;
  Faults& faults_;
};

// Numbers the groups in the order in which they come.
class GroupNumbers {
 public:
  std::size_t of(const PathAnnotation& entry) {
    if (!entry.group) return next_++;
    const auto [at, fresh] = numbers_.emplace(*entry.group, next_);
    if (fresh) ++next_;
    return at->second;
  }

 private:
  std::unordered_map<std::int64_t, std::size_t> numbers_;
  std::size_t next_ = 0;
};

std::vector<ReferencePath> look_up(const Annotations& annotations, const graph::GraphSet& graphs,
                                   const ObjectBoxes* objects, Faults& faults) {
  std::vector<ReferencePath> paths;
  paths.reserve(annotations.paths.size());
  const Path root;
  GroupNumbers groups;
  for (const PathAnnotation& entry : annotations.paths) {
    const Path path(root, paths.size());
    ReferencePath& reference = paths.emplace_back();
    reference.path_id = entry.path_id;
    reference.heading = entry.heading;
    reference.group = groups.of(entry);
    const auto scan = graphs.find(entry.scan);
    if (!scan) {
      faults.error(Path(path, "scan"), "unknown-scan",
                   fmt::format("scan {} is not one of the {} with a graph", quote(entry.scan),
                               graphs.size()));
      continue;
    }
    reference.scan = *scan;
    LookUp names(entry, graphs.graph(*scan), benchmark(annotations.task).along_edges, faults);
    reference.viewpoints = names.path(Path(path, "path"));
    reference.goal = names.goal(path, objects);
  }
  return paths;
}

}  // namespace

std::string instruction_id(std::int64_t path_id, std::size_t k) {
  return fmt::format("{}_{}", path_id, k);
}

std::string instruction_id(const PathAnnotation& path, std::size_t k) {
  if (k < path.details.size() && !path.details[k].id.empty()) return path.details[k].id;
  return path.id.empty() ? instruction_id(path.path_id, k) : fmt::format("{}_{}", path.id, k);
}

bool goal_hidden(const ReferencePath& path) noexcept {
  return std::holds_alternative<HiddenGoal>(path.goal) ||
         (std::holds_alternative<NearEnd>(path.goal) && path.viewpoints.size() < 2);
}

double length_of(const ReferencePath& path, const graph::NavGraph& graph) {
  double length = 0;
  for (std::size_t k = 1; k < path.viewpoints.size(); ++k) {
    const graph::Edge* edge = graph.edge(path.viewpoints[k - 1], path.viewpoints[k]);
    length +=
        edge != nullptr ? edge->length : graph.distance(path.viewpoints[k - 1], path.viewpoints[k]);
  }
  return length;
}

std::vector<ReferencePath> look_up_paths(const Annotations& annotations,
                                         const graph::GraphSet& graphs,
                                         const ObjectBoxes* objects) {
  Faults faults(annotations.file);
  std::vector<ReferencePath> paths = look_up(annotations, graphs, objects, faults);
  faults.throw_if_errors();
  return paths;
}

EpisodeSet make_episodes(const Annotations& annotations,
                         std::shared_ptr<const graph::GraphSet> graphs, Instructions instructions,
                         const ObjectBoxes* objects) {
  const std::size_t scored = benchmark(annotations.task).scored_instructions;
  const bool some = instructions == Instructions::kScored && scored > 0;
  const std::size_t most = some ? scored : std::numeric_limits<std::size_t>::max();
  EpisodeSet set{annotations.split, std::move(graphs), {}, {}, annotations.task};
  Faults faults(annotations.file);
  set.paths = look_up(annotations, *set.graphs, objects, faults);
  const Path root;
  for (std::size_t i = 0; i < annotations.paths.size(); ++i) {
    const PathAnnotation& entry = annotations.paths[i];
    const std::size_t n = std::min(entry.instructions.size(), most);
    if (n == 0) {
      faults.error(Path(Path(root, i), "instructions"), "no-instruction",
                   fmt::format("path {} has none to follow", entry.path_id));
    }
    for (std::size_t k = 0; k < n; ++k) {
      Episode& episode = set.episodes.emplace_back(
          Episode{instruction_id(entry, k), i, k, entry.instructions[k], InstructionDetails()});
      if (k < entry.details.size()) episode.details = entry.details[k];
    }
  }
  faults.throw_if_errors();
  return set;
}

}  // namespace enfilade::tasks
