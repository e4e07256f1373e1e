/// \file  Where an agent with a map ends: at the place that looked most like the goal.
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

/// When an agent goes back, after its last action, to where stopping was most probable.
enum class FinalStop {
  kAlways,     ///< the released DUET: also after a stop of its own
  kUnlessOwn,  ///< where it stopped by itself it stays; else as above
};

/// How probable stopping was at each place that an agent has visited. clear() keeps the memory.
class StopMemory {
 public:
  using Node = TopologicalMap::Node;  ///< of the map

  void clear() { known_.clear(); }  ///< nothing is remembered
  /// The probability of stopping at a node where the agent stands. What was remembered of the same
  /// node is replaced, at its old place in the order.
  void remember(Node node, double probability);
  /// The node with the highest probability, the first remembered of equals. No value: none is
  /// known.
  std::optional<Node> best() const;

 private:
  std::vector<std::pair<Node, double>> known_;
};

/// The walk after the last action: to memory.best() along known edges, without `here`; empty where
/// the agent stays. \pre `here` and what is remembered are nodes of the map
void final_walk(const TopologicalMap& map, TopologicalMap::Node here, const StopMemory& memory,
                LastAction last, FinalStop rule, std::vector<ViewpointIndex>& out);

}  // namespace enfilade::agents
