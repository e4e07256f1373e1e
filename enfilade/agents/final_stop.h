/// \file  Last viewpoint of an agent with a map: the one with the greatest probability of stopping.
#pragma once
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/agents/topological_map.h"
#include "enfilade/core/ids.h"

namespace enfilade::agents {

/// Why an agent has chosen its last action.
enum class LastAction {
  kStop,         ///< it stopped by itself
  kNothingOpen,  ///< no open node was left to go to
  kLimit,        ///< the most actions that an episode may have are used up
};

/// When an agent, after its last action, goes back to the viewpoint where stopping was most
/// probable.
enum class FinalStop {
  kAlways,     ///< the released DUET: also after a stop of its own
  kUnlessOwn,  ///< where it stopped by itself it stays; else as above
};

/// How probable stopping was at each place that an agent has visited. clear() keeps the memory.
class StopMemory {
 public:
  using Node = TopologicalMap::Node;  ///< of the map

  void clear() { known_.clear(); }  ///< forgets all
  /// The probability of stopping at the agent's node. An earlier one of the same node is replaced,
  /// at its old position in the order.
  void remember(Node node, double probability);
  /// The node with the highest probability, the first remembered of equals. No value: none is
  /// known.
  std::optional<Node> best() const;

 private:
  std::vector<std::pair<Node, double>> known_;
};

/// The path after the last action: to memory.best() along known edges, without `here`; empty if the
/// agent stays.
/// \pre `here` and all nodes of the memory are nodes of the map
void final_walk(const TopologicalMap& map, TopologicalMap::Node here, const StopMemory& memory,
                LastAction last, FinalStop rule, std::vector<ViewpointIndex>& out);

}  // namespace enfilade::agents
