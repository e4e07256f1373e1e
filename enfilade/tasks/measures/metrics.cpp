#include "enfilade/tasks/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <variant>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/goal_distance.h"
#include "enfilade/tasks/results.h"

namespace enfilade::tasks {
namespace {

constexpr double kUnreached = std::numeric_limits<double>::infinity();

// part / whole of two lengths, part <= whole: 1 if both are 0, 0 if whole is infinite.
double share(double part, double whole) {
  if (!std::isfinite(whole)) return 0;
  return whole > 0 ? part / whole : 1;
}

// Computes time warping and coverage in one pass over P: both use the distances of an entry to all
// of R, and an entry that repeats the one before reuses them.
class Pass {
 public:
  Pass(const graph::NavGraph& graph, std::span<const ViewpointIndex> reference)
      : graph_(graph), reference_(reference), rows_(4 * reference.size(), kUnreached) {}

  void turn() { align(row(kWarp)); }

  void visit(ViewpointIndex viewpoint) {
    const auto distance = row(kDistance);
    const auto nearest = row(kNearest);
    for (std::size_t j = 0; j < reference_.size(); ++j) {
      distance[j] = graph_.distance(viewpoint, reference_[j]);
      nearest[j] = std::min(nearest[j], distance[j]);
    }
    align(row(kWarp));
    align(row(kCollapsed));
    first_ = false;
  }

  double goal_distance() { return row(kDistance).back(); }  // of the entry visited last
  double least_goal_distance() { return row(kNearest).back(); }
  double dtw() { return row(kWarp).back(); }
  double dtw_collapsed() { return row(kCollapsed).back(); }
  std::span<const double> nearest() { return row(kNearest); }

 private:
  enum Row : std::size_t { kDistance, kNearest, kWarp, kCollapsed };
  std::span<double> row(Row which) {
    return std::span(rows_).subspan(which * reference_.size(), reference_.size());
  }

  // Replaces the last row of the time warping by the next: costs[j] becomes the least cost of
  // aligning the entries so far with R up to j.
  void align(std::span<double> costs) {
    const auto distance = row(kDistance);
    double diagonal = first_ ? 0 : kUnreached;
    double left = kUnreached;
    for (std::size_t j = 0; j < costs.size(); ++j) {
      const double above = costs[j];
      left = distance[j] + std::min(left, std::min(above, diagonal));
      costs[j] = left;
      diagonal = above;
    }
  }

  const graph::NavGraph& graph_;
  std::span<const ViewpointIndex> reference_;
  std::vector<double> rows_;
  bool first_ = true;
};

double coverage(std::span<const double> nearest, double success_distance) {
  double sum = 0;
  for (const double distance : nearest) sum += std::exp(-distance / success_distance);
  return sum / static_cast<double>(nearest.size());
}

// Coverage times the length score of Jain et al.: how near TL is to coverage * reference length.
double cls(const EpisodeMetrics& m) {
  if (m.coverage == 0 || !std::isfinite(m.reference_length)) return 0;
  const double expected = m.coverage * m.reference_length;
  return m.coverage * share(expected, expected + std::abs(expected - m.trajectory_length));
}

}  // namespace

double walked(const graph::NavGraph& graph, std::span<const ViewpointIndex> path) {
  double sum = 0;
  for (std::size_t i = 1; i < path.size(); ++i) {
    if (path[i] != path[i - 1]) sum += graph.distance(path[i - 1], path[i]);
  }
  return sum;
}

EpisodeMetrics compute_metrics(const graph::NavGraph& graph,
                               std::span<const ViewpointIndex> trajectory,
                               std::span<const ViewpointIndex> reference,
                               const MetricOptions& options) {
  EN_CHECK(!trajectory.empty());
  EN_CHECK(!reference.empty());
  EpisodeMetrics m;
  Pass pass(graph, reference);
  pass.visit(trajectory[0]);
  for (std::size_t i = 1; i < trajectory.size(); ++i) {
    if (trajectory[i] == trajectory[i - 1]) {
      pass.turn();
      continue;
    }
    pass.visit(trajectory[i]);
    ++m.moves;
  }
  m.steps = static_cast<double>(trajectory.size() - 1);
  m.trajectory_length = walked(graph, trajectory);
  m.reference_length = walked(graph, reference);
  m.shortest = graph.distance(reference.front(), reference.back());
  m.nav_error = pass.goal_distance();
  m.oracle_error = pass.least_goal_distance();
  m.success = m.nav_error < options.success_distance ? 1 : 0;
  m.oracle_success = m.oracle_error < options.success_distance ? 1 : 0;
  m.spl = m.success * share(m.shortest, std::max(m.trajectory_length, m.shortest));
  m.spl_refpath =
      m.success * share(m.reference_length, std::max(m.trajectory_length, m.reference_length));
  const double scale = static_cast<double>(reference.size()) * options.success_distance;
  m.dtw = pass.dtw();
  m.ndtw = std::exp(-m.dtw / scale);
  m.sdtw = m.success * m.ndtw;
  m.dtw_collapsed = pass.dtw_collapsed();
  m.ndtw_collapsed = std::exp(-m.dtw_collapsed / scale);
  m.sdtw_collapsed = m.success * m.ndtw_collapsed;
  m.coverage = coverage(pass.nearest(), options.success_distance);
  m.cls = cls(m);
  return m;
}

EpisodeMetrics compute_metrics(const graph::NavGraph& graph, const ReferencePath& path,
                               const Trajectory& trajectory, const MetricOptions& options) {
  thread_local std::vector<ViewpointIndex> viewpoints;
  viewpoints.clear();
  for (const TrajectoryPoint& point : trajectory.points) viewpoints.push_back(point.viewpoint);
  EpisodeMetrics m = compute_metrics(graph, viewpoints, path.viewpoints, options);
  if (std::holds_alternative<NearEnd>(path.goal)) return m;
  const GoalOutcome outcome = judge(graph, path, trajectory, options.success_distance);
  m.nav_error = outcome.error;
  m.oracle_error = outcome.oracle_error;
  m.success = outcome.reached ? 1 : 0;
  m.oracle_success = outcome.oracle_reached ? 1 : 0;
  m.shortest = outcome.shortest;
  // Also where the end is out of reach, and `shortest` infinite.
  m.spl = m.success * (m.trajectory_length > m.shortest ? m.shortest / m.trajectory_length : 1);
  return m;
}

}  // namespace enfilade::tasks
