#include "enfilade/agents/final_stop.h"

#include <algorithm>

namespace enfilade::agents {

void StopMemory::remember(Node node, double probability) {
  const auto known = std::ranges::find(known_, node, &std::pair<Node, double>::first);
  if (known == known_.end()) {
    known_.emplace_back(node, probability);
  } else {
    known->second = probability;
  }
}

std::optional<StopMemory::Node> StopMemory::best() const {
  const auto best = std::ranges::max_element(known_, {}, &std::pair<Node, double>::second);
  if (best == known_.end()) return std::nullopt;
  return best->first;
}

void final_walk(const TopologicalMap& map, TopologicalMap::Node here, const StopMemory& memory,
                LastAction last, FinalStop rule, std::vector<ViewpointIndex>& out) {
  out.clear();
  if (rule == FinalStop::kUnlessOwn && last == LastAction::kStop) return;
  if (const auto best = memory.best()) map.path(here, *best, out);
}

}  // namespace enfilade::agents
