#include "enfilade/service/goal_keys.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <variant>

#include "enfilade/core/rng.h"

namespace enfilade::service {
namespace {

/// \param end empty: the start alone
std::uint64_t key_of(const graph::NavGraph& graph, ViewpointIndex start, std::string_view end) {
  // Ids have no line breaks.
  const std::string text =
      std::string(graph.scan()) + '\n' + std::string(graph.id(start)) + '\n' + std::string(end);
  return stream_of(text.data(), text.size());
}

/// The ends of a goal beside the last viewpoint of its path.
std::vector<ViewpointIndex> other_ends(const tasks::Goal& goal) {
  if (const auto* turn = std::get_if<tasks::TurningPoint>(&goal)) return {turn->viewpoint};
  if (const auto* object = std::get_if<tasks::SeenObject>(&goal)) return object->seen_from;
  if (const auto* region = std::get_if<tasks::Region>(&goal)) return region->viewpoints;
  std::vector<ViewpointIndex> ends;
  if (const auto* boxes = std::get_if<tasks::Boxes>(&goal)) {
    for (const tasks::Box& box : boxes->boxes) ends.push_back(box.viewpoint);
  }
  return ends;
}

void make_set(GoalKeys& keys) {
  std::ranges::sort(keys);
  keys.erase(std::ranges::unique(keys).begin(), keys.end());
}

}  // namespace

GoalKeys goal_keys(std::span<const tasks::ReferencePath> paths, tasks::Task task,
                   const graph::GraphSet& graphs) {
  GoalKeys keys;
  for (const tasks::ReferencePath& path : paths) {
    if (tasks::goal_hidden(path)) continue;
    const graph::NavGraph& graph = graphs.graph(path.scan);
    const auto add = [&](ViewpointIndex start, ViewpointIndex end) {
      if (start != end) keys.push_back(key_of(graph, start, graph.id(end)));
    };
    const std::vector<ViewpointIndex>& steps = path.viewpoints;
    const std::size_t starts = tasks::benchmark(task).joins_paths ? steps.size() : 1;
    for (std::size_t k = 0; k < starts; ++k) {
      for (std::size_t end = starts == 1 ? steps.size() - 1 : k + 1; end < steps.size(); ++end) {
        add(steps[k], steps[end]);
      }
    }
    for (const ViewpointIndex end : other_ends(path.goal)) add(steps.front(), end);
  }
  make_set(keys);
  return keys;
}

GoalKeys goal_keys(const tasks::ContinuousEpisodes& episodes, const graph::GraphSet& graphs) {
  GoalKeys keys;
  for (const tasks::ContinuousEpisode& episode : episodes.episodes) {
    const auto scan = graphs.find(episode.scan());
    if (!scan) continue;
    const graph::NavGraph& graph = graphs.graph(*scan);
    const auto start = graph.nearest(to_float(episode.start));
    if (!start) continue;
    const auto add = [&](Vec3d place) {
      const auto end = graph.nearest(to_float(place));
      if (end && *end != *start) keys.push_back(key_of(graph, *start, graph.id(*end)));
    };
    if (episode.reference_path && !episode.reference_path->empty()) {
      add(episode.reference_path->back());
    }
    if (!episode.goals) continue;
    for (const tasks::ContinuousGoal& goal : *episode.goals) add(goal.position);
  }
  make_set(keys);
  return keys;
}

GoalKeys goal_keys(const tasks::Split& split, const graph::GraphSet& graphs) {
  const auto& on_graph = split.on_graph();
  return on_graph ? goal_keys(on_graph->paths, on_graph->task, graphs)
                  : goal_keys(*split.continuous(), graphs);
}

GoalKeys start_keys(std::span<const tasks::ReferencePath> paths, const graph::GraphSet& graphs) {
  GoalKeys keys;
  for (const tasks::ReferencePath& path : paths) {
    keys.push_back(key_of(graphs.graph(path.scan), path.viewpoints.front(), {}));
  }
  make_set(keys);
  return keys;
}

SharedKeys shared_keys(const GoalKeys& one, const GoalKeys& other) {
  SharedKeys found{0, std::min(one.size(), other.size())};
  for (auto a = one.begin(), b = other.begin(); a != one.end() && b != other.end();) {
    if (*a == *b) ++found.shared;
    const bool first = *a <= *b, second = *b <= *a;
    if (first) ++a;
    if (second) ++b;
  }
  return found;
}

}  // namespace enfilade::service
