// REVERIE's scorers: success is to end where the object is seen, however far the path's end is.
#include <algorithm>
#include <string>
#include <variant>

#include "enfilade/tasks/scorers/scorers.h"

namespace enfilade::tasks::scorers {
namespace {

struct Found {
  double steps = 0, walked = 0, shortest = 0, reference = 0;
  bool success = false, oracle = false, named = false;
};

Found find(const Scored& scored) {
  const auto& goal = std::get<SeenObject>(scored.reference.goal);
  const auto path = viewpoints_of(scored.trajectory);
  const std::span<const ViewpointIndex> reference = scored.reference.viewpoints;
  const auto sees = [&goal](ViewpointIndex v) {
    return std::ranges::binary_search(goal.seen_from, v);
  };
  Found found;
  found.steps = static_cast<double>(path.size() - 1);
  found.walked = walked(scored.graph, path);
  found.shortest = scored.graph.distance(reference.front(), reference.back());
  found.reference = walked(scored.graph, reference);
  found.success = sees(path.back());
  found.oracle = std::ranges::any_of(path, sees);
  // As texts: "66" is the object 66, "066" is not. Where the agent stands is not asked.
  found.named = scored.trajectory.object == std::to_string(goal.id);
  return found;
}

// The last six of DUET's and HAMT's metrics.
void put_common(const Found& found, Out out) {
  out[0] = found.walked;
  out[1] = found.success ? 1 : 0;
  out[2] = found.oracle ? 1 : 0;
  out[3] = spl(found.success, found.reference, found.walked, kGuard);
  out[4] = found.named ? 1 : 0;
  out[5] = spl(found.named, found.reference, found.walked, kGuard);
}

}  // namespace

void reverie_official(const Scored& scored, Out out) {
  const Found found = find(scored);
  out[0] = found.walked;
  out[1] = found.success ? 1 : 0;
  out[2] = found.oracle ? 1 : 0;
  out[3] = spl(found.success, found.shortest, found.walked, 0);
  out[4] = found.named ? 1 : 0;
  out[5] = spl(found.named, found.shortest, found.walked, 0);
  out[6] = found.shortest;
}

void reverie_duet(const Scored& scored, Out out) {
  const Found found = find(scored);
  out[0] = action_steps(scored.trajectory);
  out[1] = found.steps;
  put_common(found, out.subspan(2));
}

void reverie_hamt(const Scored& scored, Out out) {
  const Found found = find(scored);
  out[0] = found.steps;
  put_common(found, out.subspan(1));
}

}  // namespace enfilade::tasks::scorers
