// Scorers of benchmarks whose instructions lead along a path: R2R, R2R-Last, R2R-Back, R4R, RxR.
#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>

#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/scorers/scorers.h"

namespace enfilade::tasks::scorers {
namespace {

struct Measured {
  std::vector<ViewpointIndex> path;
  EpisodeMetrics metrics;
};

Measured measure(const Scored& scored) {
  Measured m{viewpoints_of(scored.trajectory), {}};
  m.metrics = compute_metrics(scored.graph, m.path, scored.reference.viewpoints,
                              {.success_distance = kSuccessDistance});
  return m;
}

// Coverage weighted by length; ours where 0 / 0 has been given a value.
double cls(const EpisodeMetrics& m, double undefined) {
  const double expected = m.coverage * m.reference_length;
  const bool nothing = expected == 0 && m.trajectory_length == 0;
  return nothing ? undefined : m.cls;
}

// The last eight of HAMT's and DUET's metrics.
void put_common(const EpisodeMetrics& m, Out out) {
  out[0] = m.trajectory_length;
  out[1] = m.success;
  out[2] = spl(m.success > 0, m.reference_length, m.trajectory_length, kGuard);
  out[3] = m.oracle_success;
  out[4] = m.dtw;
  out[5] = m.ndtw;
  out[6] = m.sdtw;
  out[7] = cls(m, kNone);
}

bool walks_edges(const graph::NavGraph& graph, std::span<const ViewpointIndex> path) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (graph.edge(path[i - 1], path[i]) == nullptr) return false;
  }
  return true;
}

}  // namespace

void hamt(const Scored& scored, Out out) {
  const EpisodeMetrics m = measure(scored).metrics;
  out[0] = m.nav_error;
  out[1] = m.oracle_error;
  out[2] = m.steps;
  put_common(m, out.subspan(3));
}

void duet(const Scored& scored, Out out) {
  const EpisodeMetrics m = measure(scored).metrics;
  out[0] = m.nav_error;
  out[1] = m.oracle_error;
  out[2] = action_steps(scored.trajectory);
  out[3] = m.steps;
  put_common(m, out.subspan(4));
}

void valan(const Scored& scored, Out out) {
  const EpisodeMetrics m = measure(scored).metrics;
  out[0] = m.nav_error;
  out[1] = m.success;
  out[2] = m.oracle_success;
  out[3] = spl(m.success > 0, m.shortest, m.trajectory_length, 0);
  out[4] = m.trajectory_length;
  out[5] = m.steps;
  out[6] = m.dtw / m.reference_length;  // nan or infinite for a reference of one viewpoint
  out[7] = m.ndtw;
  out[8] = m.sdtw;
  out[9] = cls(m, 1);
}

void r4r_public(const Scored& scored, Out out) {
  const Measured measured = measure(scored);
  const EpisodeMetrics& m = measured.metrics;
  out[0] = m.dtw;
  out[1] = m.ndtw;
  out[2] = m.nav_error <= kSuccessDistance ? m.ndtw : 0;  // this one counts an end at 3 m
  // Its lengths are looked up among the edges, where a viewpoint has none to itself.
  out[3] = walks_edges(scored.graph, measured.path) ? cls(m, kNone) : kNone;
}

void hamt_back(const Scored& scored, Out out) {
  const EpisodeMetrics m = measure(scored).metrics;
  const auto& turn = std::get<TurningPoint>(scored.reference.goal);
  const auto& said = scored.trajectory.turning_point;
  const bool success = said && scored.graph.distance(*said, turn.viewpoint) <= kSuccessDistance &&
                       m.nav_error <= kSuccessDistance;
  out[0] = m.nav_error;
  out[1] = m.steps;
  out[2] = m.trajectory_length;
  out[3] = success ? 1 : 0;
  out[4] = spl(success, m.reference_length, m.trajectory_length, kGuard);
  out[5] = m.dtw;
  out[6] = m.ndtw;
  out[7] = success ? m.ndtw : 0;
  out[8] = cls(m, kNone);
}

}  // namespace enfilade::tasks::scorers
