#include "enfilade/neural/duet/labels.h"

#include <fmt/format.h>
#include <limits>

#include "enfilade/core/errors.h"

namespace enfilade::neural::duet {

std::int64_t neighbour_label(const graph::NavGraph& graph, ViewpointIndex here, ViewpointIndex goal,
                             std::span<const ViewpointIndex> neighbours) {
  if (here == goal) return 0;
  std::int64_t best = kNoLabel;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < neighbours.size(); ++i) {
    // In this order, as agents::map_expert(): the last bit decides between nodes of one way.
    const double way = graph.distance(neighbours[i], goal) + graph.distance(here, neighbours[i]);
    if (way < least) {
      least = way;
      best = static_cast<std::int64_t>(i) + 1;
    }
  }
  return best;
}

ViewpointIndex next_on_reference(const graph::NavGraph& graph, ViewpointIndex here,
                                 std::size_t step, std::span<const ViewpointIndex> reference) {
  if (step >= reference.size() || reference[step] != here) {
    throw ArgumentError(
        fmt::format("the agent is at {:?} at step {}, which is not where the annotated path is",
                    graph.id(here), step));
  }
  return reference[step + 1 == reference.size() ? step : step + 1];
}

}  // namespace enfilade::neural::duet
