#include "enfilade/tasks/scorer.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/tasks/scorers/scorers.h"

namespace enfilade::tasks {
namespace {

using enum MeanRule;

double mean(const Scorer& scorer, std::size_t metric, std::span<const double> values) {
  const std::size_t width = scorer.metrics.size();
  const MeanRule rule = scorer.metrics[metric].rule;
  double sum = 0;
  std::size_t n = 0;
  for (std::size_t at = metric; at < values.size(); at += width) {
    if (rule == kWhereDefined && std::isnan(values[at])) continue;
    sum += values[at];
    ++n;
  }
  if (rule == kNone || n == 0) return std::numeric_limits<double>::quiet_NaN();
  constexpr double kGuard = 1e-9;  // SOON's released scorer adds it to the number of episodes
  return sum / (static_cast<double>(n) + (rule == kGuarded ? kGuard : 0)) *
         scorer.metrics[metric].scale;
}

}  // namespace

std::size_t Scorer::place_of(std::string_view mean_name) const {
  const auto found = std::ranges::find_if(
      metrics, [mean_name](const ScorerMetric& m) { return mean_name == m.mean_name(); });
  if (found != metrics.end()) return static_cast<std::size_t>(found - metrics.begin());
  std::vector<std::string_view> names;
  for (const ScorerMetric& one : metrics) names.emplace_back(one.mean_name());
  throw LookupError(
      fmt::format("no metric {}; there are {}", quote(mean_name), fmt::join(names, ", ")));
}

const Scorer& own_scorer() noexcept { return scorers::kR2r.front(); }

const Measure* find_measure(std::span<const Measure> measures, std::string_view name) noexcept {
  const auto found = std::ranges::find(measures, name, &Measure::name);
  return found == measures.end() ? nullptr : &*found;
}

std::vector<double> summarise(const Scorer& scorer, std::span<const double> values) {
  const std::size_t width = scorer.metrics.size();
  EN_CHECK_EQ(values.size() % width, std::size_t{0});
  std::vector<double> means(width);
  for (std::size_t metric = 0; metric < width; ++metric) {
    means[metric] = mean(scorer, metric, values);
  }
  return means;
}

namespace scorers {

std::vector<ViewpointIndex> viewpoints_of(const Trajectory& trajectory) {
  std::vector<ViewpointIndex> viewpoints;
  viewpoints.reserve(trajectory.points.size());
  for (const TrajectoryPoint& point : trajectory.points) viewpoints.push_back(point.viewpoint);
  return viewpoints;
}

double nearest(const graph::NavGraph& graph, ViewpointIndex from,
               std::span<const ViewpointIndex> to) {
  double least = std::numeric_limits<double>::infinity();
  for (const ViewpointIndex one : to) least = std::min(least, graph.distance(from, one));
  return least;
}

double action_steps(const Trajectory& trajectory) {
  return static_cast<double>(trajectory.actions.value_or(trajectory.points.size() - 1));
}

double spl(bool success, double length, double walked, double guard) {
  const double divisor = std::max({walked, length, guard});
  return success && divisor > 0 ? length / divisor : 0;
}

// The scorers that are measures of other headers.

void own(const Scored& scored, Out out) {
  const EpisodeMetrics metrics =
      compute_metrics(scored.graph, scored.reference, scored.trajectory, scored.options);
  std::size_t k = 0;
  for (const MetricField& field : kMetricFields) out[k++] = metrics.*field.field;
}

void vlnce(const ContinuousWalk& walk, std::span<const Point3> reference, Out out) {
  std::ranges::copy(vlnce_values(score_continuous(walk, reference)), out.begin());
}

void etpnav(const ContinuousWalk& walk, std::span<const Point3> reference, Out out) {
  const EtpNavScore s = score_as_etpnav(walk, reference);
  std::ranges::copy(std::array{s.path_length, s.distance_to_goal, s.success, s.oracle_success,
                               s.spl, s.ndtw, s.sdtw, s.steps_taken, s.collisions},
                    out.begin());
}

}  // namespace scorers
}  // namespace enfilade::tasks
