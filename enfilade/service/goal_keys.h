/// \file  Keys of goals: equal wherever the same scan has the same start and the same end, in any
/// benchmark, split or file. So what is secret in one file is found in another.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/split.h"

namespace enfilade::service {

/// Hashes of 64 bits of a scan, a start and an end, ascending, each once. Databases keep them, so
/// the hash never changes. A person with a key and the graphs finds its end by trying all ends.
using GoalKeys = std::vector<std::uint64_t>;

/// The keys of paths: each start with every end of its goal. An end is the path's last viewpoint or
/// a turning point (R2R-Back). Or it sees the object (REVERIE), has a box (SOON), or lies in the
/// region (CVDN). R4R joins two paths, so each pair of its viewpoints in their order counts.
/// Hidden goals have none.
GoalKeys goal_keys(std::span<const tasks::ReferencePath> paths, tasks::Task task,
                   const graph::GraphSet& graphs);
/// The same of continuous episodes, by the viewpoints nearest to their starts and goals. Scans
/// without a graph are left out.
GoalKeys goal_keys(const tasks::ContinuousEpisodes& episodes, const graph::GraphSet& graphs);
GoalKeys goal_keys(const tasks::Split& split, const graph::GraphSet& graphs);
/// Starts alone, in keys of their own.
GoalKeys start_keys(std::span<const tasks::ReferencePath> paths, const graph::GraphSet& graphs);

/// How many keys two sets share.
struct SharedKeys {
  std::size_t shared = 0;
  std::size_t smaller = 0;  ///< size of the smaller set

  /// Whether one set gives the other away: at least a tenth of the smaller one is shared. A few
  /// equal paths are chance. To hide these alone would mark them as secret.
  bool tells() const noexcept { return shared > 0 && 10 * shared >= smaller; }
};
/// \pre both ascend
SharedKeys shared_keys(const GoalKeys& one, const GoalKeys& other);

}  // namespace enfilade::service
