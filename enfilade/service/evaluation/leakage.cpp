#include "enfilade/service/evaluation/leakage.h"

#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <variant>

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

/// Continuous episodes start on the floor under a viewpoint.
ViewpointIndex nearest_viewpoint(const graph::NavGraph& graph, Vec3d place) {
  ViewpointIndex nearest(0);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t v = 0; v < graph.size(); ++v) {
    const double away = length(to_double(graph.position(ViewpointIndex(v))) - place);
    if (away >= least) continue;
    least = away;
    nearest = ViewpointIndex(v);
  }
  return nearest;
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

double goal_bits(const SecretEpisodes& secret, const graph::GraphSet& graphs) {
  double bits = 0;
  const auto add = [&bits](std::size_t possible) {
    if (possible > 0) bits += std::log2(static_cast<double>(possible));
  };
  if (const auto* episodes = std::get_if<tasks::EpisodeSet>(&secret)) {
    for (const tasks::ReferencePath& path : episodes->paths) {
      add(count_in_reach(episodes->graphs->graph(path.scan), path.viewpoints.front()));
    }
    return bits;
  }
  std::set<std::string> seen;
  for (const auto& episode : std::get<ContinuousGoals>(secret).episodes.episodes) {
    if (!seen.insert(tasks::text_of(episode.trajectory_id)).second) continue;
    const graph::NavGraph& graph = graphs.graph(episode.scan());
    add(count_in_reach(graph, nearest_viewpoint(graph, episode.start)));
  }
  return bits;
}

}  // namespace enfilade::service::evaluation
