/// \file  Scoring a results file: per-episode metrics, means and their intervals.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/bootstrap.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/results.h"

namespace enfilade::tasks {

/// How a results file is scored.
struct ScoreOptions {
  MetricOptions metrics;
  int threads = 0;               ///< 0: all cores; never changes a result
  int bootstrap_samples = 1000;  ///< 0: no intervals
  std::uint64_t bootstrap_seed = 1;
};

/// The metrics of every episode of a split, and their means.
struct Score {
  std::string split;
  ScoreOptions options;                  ///< options of its computation
  std::vector<EpisodeMetrics> episodes;  ///< in the order of EpisodeSet::episodes
  std::vector<MeanInterval> means;       ///< in the order of metric_fields()

  /// By name ("success"). \throws LookupError
  const MeanInterval& mean(std::string_view metric) const;
};

/// The metrics of every trajectory, in their order, on all cores; nothing else.
/// \throws ArgumentError if a trajectory names no episode, is empty or leaves its graph, if a goal
/// is hidden, or for a success distance that isn't positive
std::vector<EpisodeMetrics> score_trajectories(const std::vector<Trajectory>& trajectories,
                                               const EpisodeSet& episodes,
                                               const MetricOptions& options, int threads);

/// score_trajectories() and the means with their bootstrap 95 % percentile intervals. The bootstrap
/// draws *paths*, each with its three instructions, because those are not independent samples
/// (docs/design/bootstrap.md).
/// \throws as score_trajectories(); ArgumentError also unless each episode has one trajectory
Score compute_score(const std::vector<Trajectory>& trajectories, const EpisodeSet& episodes,
                    const ScoreOptions& options = {});

/// The same for a results file. \throws as compute_score() of trajectories
inline Score compute_score(const Results& results, const EpisodeSet& episodes,
                           const ScoreOptions& options = {}) {
  return compute_score(results.trajectories, episodes, options);
}

/// Whether a path's goal is hidden, so that the split can be run but not scored.
bool goals_hidden(const EpisodeSet& episodes) noexcept;

/// {"split", "episodes": n, "options": {...}, "means": {metric: {mean, low, high}}}; intervals are
/// left out if there are none. A number that is not finite (a goal out of reach) is null.
std::string to_json(const Score& score);
/// The same with "per_episode": {instr_id: {metric: value}}.
std::string to_json(const Score& score, const EpisodeSet& episodes);

/// Which of the two SPLs a table shows.
enum class SplLength {
  kShortest,   ///< of the shortest path to the goal (Anderson et al. 2018b)
  kReference,  ///< of the reference path, as DUET evaluates
};
/// A table for people: TL NE SR OSR SPL nDTW sDTW CLS steps, each with its interval; shares in per
/// cent. Its nDTW and sDTW are the collapsed ones (docs/design/dtw-of-turns.md).
std::string to_table(const Score& score, SplLength spl = SplLength::kShortest);

}  // namespace enfilade::tasks
