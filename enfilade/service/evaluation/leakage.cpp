#include "enfilade/service/evaluation/leakage.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <set>
#include <string>

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

bool share_goals(const Phase* one, const Phase* other) {
  if (!one->goals_secret() || !other->goals_secret()) return one == other;
  if (one->split == other->split && share_paths(*one->benchmark, *other->benchmark)) return true;
  std::error_code error;  // the files were read before; one that is gone now equals none
  return std::filesystem::equivalent(one->annotations, other->annotations, error);
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

double goal_bits(const tasks::Split& split, const graph::GraphSet& graphs) {
  double bits = 0;
  const auto add = [&bits](std::size_t possible) {
    if (possible > 0) bits += std::log2(static_cast<double>(possible));
  };
  if (const auto& episodes = split.on_graph()) {
    for (const tasks::ReferencePath& path : episodes->paths) {
      add(count_in_reach(episodes->graphs->graph(path.scan), path.viewpoints.front()));
    }
    return bits;
  }
  std::set<std::string> seen;
  for (const tasks::ContinuousEpisode& episode : split.continuous()->episodes) {
    if (!seen.insert(tasks::text_of(episode.trajectory_id)).second) continue;
    const graph::NavGraph& graph = graphs.graph(episode.scan());
    // They start on the floor under a viewpoint.
    const auto start = graph.nearest(to_float(episode.start));
    if (start) add(count_in_reach(graph, *start));
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

SharedGoals::SharedGoals(const Site& site) {
  for (const Phase& phase : site.phases()) {
    const tasks::Split& split = site.secret_episodes(phase).split;
    PhaseGroup joined{{&phase}, phase.goals_secret() ? goal_bits(split, site.graphs()) : 0};
    const auto is_apart = [&phase](const PhaseGroup& group) {
      return std::ranges::none_of(
          group.phases, [&phase](const Phase* other) { return share_goals(&phase, other); });
    };
    // The phase may join groups that were apart so far.
    const auto touched = std::stable_partition(groups_.begin(), groups_.end(), is_apart);
    for (auto group = touched; group != groups_.end(); ++group) {
      joined.phases.insert(joined.phases.end(), group->phases.begin(), group->phases.end());
      joined.goal_bits = std::max(joined.goal_bits, group->goal_bits);
    }
    groups_.erase(touched, groups_.end());
    std::ranges::sort(joined.phases);  // they lie in one vector
    groups_.push_back(std::move(joined));
  }
}

const SharedGoals::PhaseGroup& SharedGoals::of(const Phase& phase) const {
  const auto found = std::ranges::find_if(groups_, [&phase](const PhaseGroup& group) {
    return std::ranges::find(group.phases, &phase) != group.phases.end();
  });
  EN_CHECK(found != groups_.end());
  return *found;
}

}  // namespace enfilade::service::evaluation
