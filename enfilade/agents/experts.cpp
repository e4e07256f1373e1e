#include "enfilade/agents/experts.h"

#include <fmt/format.h>
#include <limits>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/tasks/metrics.h"

namespace enfilade::agents {
namespace {

double ndtw_by(const ExpertView& view, ViewpointIndex node) {
  std::vector<ViewpointIndex> walk(view.walked.begin(), view.walked.end());
  const auto way = view.graph.path(view.walked.back(), node);
  if (!way) return -std::numeric_limits<double>::infinity();
  walk.insert(walk.end(), way->begin() + 1, way->end());
  return tasks::compute_metrics(view.graph, walk, view.reference).ndtw;
}

}  // namespace

std::string_view to_string(ExpertRule rule) noexcept {
  return rule == ExpertRule::kSpl ? "spl" : "ndtw";
}

ExpertRule parse_expert_rule(std::string_view name) {
  for (const ExpertRule rule : {ExpertRule::kSpl, ExpertRule::kNdtw}) {
    if (name == to_string(rule)) return rule;
  }
  throw ArgumentError(fmt::format("expert {}: spl or ndtw is allowed", quote(name)));
}

std::optional<ViewpointIndex> next_on_shortest(const graph::NavGraph& graph, ViewpointIndex here,
                                               ViewpointIndex goal) {
  const auto path = graph.path(here, goal);
  if (!path) return std::nullopt;
  return path->size() > 1 ? path->at(1) : here;
}

std::optional<ViewpointIndex> map_expert(const ExpertView& view, ExpertRule rule) {
  const ViewpointIndex here = view.walked.back(), goal = view.reference.back();
  if (here == goal) return goal;
  std::optional<ViewpointIndex> best;
  double least = std::numeric_limits<double>::infinity();
  for (const TopologicalMap::Node node : view.map.rows()) {
    if (view.map.visited(node)) continue;
    const ViewpointIndex viewpoint = view.map.viewpoint(node);
    const double cost = rule == ExpertRule::kSpl ? view.graph.distance(viewpoint, goal) +
                                                       view.graph.distance(here, viewpoint)
                                                 : -ndtw_by(view, viewpoint);
    if (!best || cost < least) {
      best = viewpoint;
      least = cost;
    }
  }
  return best;
}

}  // namespace enfilade::agents
