#include "enfilade/service/evaluation/leakage.h"

#include <cmath>
#include <limits>

#include "enfilade/core/check.h"
#include "enfilade/service/evaluation/shown_metrics.h"

namespace enfilade::service::evaluation {
namespace {

std::size_t count_in_reach(const graph::NavGraph& graph, ViewpointIndex start) {
  std::size_t count = 0;
  for (std::size_t v = 0; v < graph.size(); ++v) {
    const ViewpointIndex viewpoint(v);
    if (viewpoint != start && std::isfinite(graph.distance(start, viewpoint))) ++count;
  }
  return count;
}

}  // namespace

double ladder_bits(std::int64_t submissions, std::int64_t levels) {
  EN_CHECK_LE(0, submissions);
  EN_CHECK_LE(1, levels);
  double bits = 0;  // a product of n factors, (L - 1 + k) / k
  for (std::int64_t k = 1; k <= submissions; ++k) {
    bits += std::log2(static_cast<double>(levels - 1 + k) / static_cast<double>(k));
  }
  return bits;
}

double row_bits(const Phase& phase, std::int64_t submissions) {
  if (submissions == 0) return 0;
  double bits = std::log2(static_cast<double>(submissions));
  for (const tasks::Measure& measure : phase.measures()) {
    if (!measure.tells_goals) continue;
    bits += std::log2(static_cast<double>(grid_of(phase, measure).levels()));
  }
  return bits;
}

double team_bits(const Phase& phase, std::int64_t submissions, bool ended) {
  if (!phase.goals_secret() || phase.scores == Scores::kHidden) return 0;
  double bits = ended ? row_bits(phase, submissions) : 0;
  if (phase.scores == Scores::kLadder) {
    bits += ladder_bits(submissions, grid_of(phase, phase.primary_measure()).levels());
  }
  return bits;
}

double most_bits(const Phase& phase) {
  if (!phase.goals_secret() || phase.scores == Scores::kHidden) return 0;
  if (!phase.per_team) return std::numeric_limits<double>::infinity();
  return phase.teams * team_bits(phase, *phase.per_team, true);
}

double used_bits(const Phase& phase, std::span<const std::int64_t> submissions, bool ended) {
  double bits = 0;
  for (const std::int64_t count : submissions) bits += team_bits(phase, count, ended);
  return bits;
}

double goal_bits(const tasks::EpisodeSet& episodes) {
  double bits = 0;
  for (const tasks::ReferencePath& path : episodes.paths) {
    const std::size_t count =
        count_in_reach(episodes.graphs->graph(path.scan), path.viewpoints.front());
    if (count > 0) bits += std::log2(static_cast<double>(count));
  }
  return bits;
}

}  // namespace enfilade::service::evaluation
