// The scorers of continuous space: VLN-CE's released measures, and ETPNav's evaluation.
#include <algorithm>
#include <array>

#include "enfilade/tasks/scorers/scorers.h"

namespace enfilade::tasks::scorers {

void vlnce(const ContinuousWalk& walk, std::span<const Point3> reference, Out out) {
  std::ranges::copy(vlnce_values(score_continuous(walk, reference)), out.begin());
}

void etpnav(const ContinuousWalk& walk, std::span<const Point3> reference, Out out) {
  const EtpNavScore s = score_as_etpnav(walk, reference);
  std::ranges::copy(std::array{s.path_length, s.distance_to_goal, s.success, s.oracle_success,
                               s.spl, s.ndtw, s.sdtw, s.steps_taken, s.collisions},
                    out.begin());
}

}  // namespace enfilade::tasks::scorers
