#include "enfilade/service/evaluation/leakage.h"

#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <utility>

#include "enfilade/core/check.h"

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

// 0.01 of shares are 0.1 m: what papers' tables show of both.
constexpr double kMetresOfStep = 10;
// Longer than what agents of any published table are away on average; a bound has to be there, as
// an unbounded number could give away any number of bits.
constexpr double kMostMetres = 30;

std::int64_t first_level(const Grid& grid) { return std::llround(grid.least / grid.step); }
std::int64_t last_level(const Grid& grid) { return std::llround(grid.most / grid.step); }

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

double means_bits(const Phase& phase) {
  double bits = 0;
  for (const tasks::Measure& measure : phase.measures()) {
    if (!measure.tells_goals) continue;
    bits += std::log2(static_cast<double>(grid_of(phase, measure).levels()));
  }
  return bits;
}

double row_bits(double of_means, std::int64_t submissions) {
  if (submissions == 0) return 0;
  return std::log2(static_cast<double>(submissions)) + of_means;
}

double team_bits(const Phase& phase, std::int64_t submissions, bool ended) {
  if (!phase.goals_secret() || phase.scores == Scores::kHidden) return 0;
  double bits = ended ? row_bits(means_bits(phase), submissions) : 0;
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

double goal_bits(const tasks::Split& split, const graph::GraphSet& graphs) {
  double bits = 0;
  std::set<std::pair<std::string, std::size_t>> starts;
  const auto add = [&](const graph::NavGraph& graph, ViewpointIndex start) {
    if (!starts.emplace(graph.scan(), start.at()).second) return;
    const std::size_t possible = count_in_reach(graph, start);
    if (possible > 0) bits += std::log2(static_cast<double>(possible));
  };
  if (const auto& episodes = split.on_graph()) {
    std::set<std::size_t> games;  // later instances start elsewhere, and end there too
    for (const tasks::ReferencePath& path : episodes->paths) {
      if (split.benchmark().starts_between && !games.insert(path.group).second) continue;
      add(episodes->graphs->graph(path.scan), path.viewpoints.front());
    }
    return bits;
  }
  for (const tasks::ContinuousEpisode& episode : split.continuous()->episodes) {
    const graph::NavGraph& graph = graphs.graph(episode.scan());
    // They start on the floor under a viewpoint.
    const auto start = graph.nearest(to_float(episode.start));
    if (start) add(graph, *start);
  }
  return bits;
}

std::int64_t Grid::levels() const { return last_level(*this) - first_level(*this) + 1; }

double Grid::round(double value) const {
  const auto first = static_cast<double>(first_level(*this));
  const auto last = static_cast<double>(last_level(*this));
  // fmax() and fmin() pass over what is no number.
  const double kept = std::fmin(std::fmax(std::round(value / step), first), last);
  // Counted from the larger part of a whole where there is one: 0.07, not 0.07000000000000001.
  const double parts = std::round(1 / step);
  return std::abs(parts * step - 1) < 1e-9 ? kept / parts : kept * step;
}

Grid grid_of(const Phase& phase, const tasks::Measure& measure) {
  EN_CHECK(measure.tells_goals);
  if (measure.unit == tasks::Unit::kShare) return {phase.step, 1};
  // Errors begin at 0; a trajectory away from the goal has negative progress.
  const bool progress = measure.better == tasks::Better::kHigher;
  return {kMetresOfStep * phase.step, kMostMetres, progress ? -kMostMetres : 0};
}

}  // namespace enfilade::service::evaluation
