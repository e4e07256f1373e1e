/// \file  Scoring a results file: per-episode metrics, means and their intervals.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/r2r/annotations.h"
#include "enfilade/r2r/metrics.h"
#include "enfilade/r2r/results.h"

namespace enfilade::r2r {

struct ScoreOptions {
  MetricOptions metrics;
  int threads = 0;                ///< 0: all cores; never changes a result
  int bootstrap_samples = 1000;   ///< 0: no intervals
  std::uint64_t bootstrap_seed = 1;
};

/// The mean of one metric over a split, with its bootstrap 95 % percentile interval.
struct MeanInterval {
  double mean = 0;
  double low = 0;
  double high = 0;
};

struct Score {
  std::string split;
  std::vector<EpisodeMetrics> episodes;  ///< in the order of EpisodeSet::episodes
  std::vector<MeanInterval> means;       ///< in the order of metric_fields()

  /// By name ("success"). \throws LookupError
  const MeanInterval& mean(std::string_view metric) const;
};

/// The metrics of every trajectory, on all cores; nothing else.
/// \throws ArgumentError if the split's goals are hidden
std::vector<EpisodeMetrics> score_trajectories(const std::vector<Trajectory>& trajectories,
                                               const EpisodeSet& episodes,
                                               const MetricOptions& options, int threads);

/// score_trajectories() and the means. The bootstrap draws *paths*, each with its three
/// instructions, because those are no independent samples (docs/design/bootstrap.md).
Score compute_score(const std::vector<Trajectory>& trajectories, const EpisodeSet& episodes,
                    const ScoreOptions& options = {});

/// {"split", "episodes": n, "means": {metric: {mean, low, high}}, "per_episode": {instr_id: {...}}}
std::string to_json(const Score& score, const EpisodeSet& episodes);
/// A table to read: TL NE SR OSR SPL nDTW sDTW CLS steps, each with its interval.
std::string to_table(const Score& score);

}  // namespace enfilade::r2r
