/// \file  Teachers of agents that choose among viewpoints: oracles, for training.
#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/agents/topological_map.h"
#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::agents {

/// By which rule DUET's pseudo-expert names the open node to go to (Chen et al., CVPR 2022, section
/// 3.3).
enum class ExpertRule : std::uint8_t {
  kSpl,   ///< shortest path to the goal through it: d(here, node) + d(node, goal)
  kNdtw,  ///< greatest nDTW of the path through it with the annotated path
};
std::string_view to_string(ExpertRule rule) noexcept;  ///< "spl", "ndtw"
ExpertRule parse_expert_rule(std::string_view name);   ///< \throws ArgumentError

/// The neighbour that is next on the shortest path; `goal` itself where it is reached. No value if
/// the goal is out of reach. \pre both are viewpoints of the graph
std::optional<ViewpointIndex> next_on_shortest(const graph::NavGraph& graph, ViewpointIndex here,
                                               ViewpointIndex goal);

/// Input of a map's teacher.
struct ExpertView {
  const graph::NavGraph& graph;  ///< the whole one: its distances, not the map's
  const TopologicalMap& map;
  /// All viewpoints of the trajectory so far, the start first and the present one last.
  std::span<const ViewpointIndex> walked;
  std::span<const ViewpointIndex> reference;  ///< the annotated path; its end is the goal
};

/// DUET's pseudo-expert: the goal if the agent is on it (that is: stop), else an open node of the
/// map. Among equal nodes, the first row. No value if no node is open. Many nodes lie on the same
/// shortest path, and then the last bit decides. Distances are summed from their first viewpoint,
/// as in NavGraph, so that they give the recorded labels.
/// \pre neither span is empty
std::optional<ViewpointIndex> map_expert(const ExpertView& view, ExpertRule rule);

}  // namespace enfilade::agents
