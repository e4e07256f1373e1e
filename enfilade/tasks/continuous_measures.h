/// \file  The measures of a split of continuous trajectories, as tables show them.
#pragma once
#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/tasks/bootstrap.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/continuous_score.h"

namespace enfilade::tasks {

/// A measure by name, and its value for one trajectory.
struct ContinuousMeasure {
  std::string_view name;   ///< "spl", as VLN-CE's code has it
  std::string_view title;  ///< "SPL (%)"
  double unit = 1;         ///< factor of the table: 100 for shares
  double (*value)(const ContinuousScore&) = nullptr;
};
/// All, in the order of tables. Collisions, which files do not have, are NaN where unknown.
std::span<const ContinuousMeasure> continuous_measures() noexcept;

/// Means over episodes.
struct ContinuousMeasures {
  std::size_t episodes = 0, trajectories = 0;
  /// Means of continuous_measures(), with intervals of 95 % by the bootstrap over trajectories;
  /// instructions of one trajectory are not independent samples. NaN where a value is missing.
  std::vector<MeanInterval> means;
};

/// \param walks  the trajectories of the scores, in the same order
/// \throws ArgumentError for no score, or for another number of trajectories than scores
ContinuousMeasures measure(std::span<const ContinuousScore> scores,
                           std::span<const ContinuousResult> walks,
                           const ContinuousEpisodes& episodes);

/// A line a measure, for people.
std::string to_table(const ContinuousMeasures& measures);
/// All measures; with `per_episode` those of each episode too, by its id. NaN is null.
std::string to_json(const ContinuousMeasures& measures, std::span<const ContinuousScore> scores,
                    std::span<const ContinuousResult> walks, const ContinuousEpisodes& episodes,
                    bool per_episode);

}  // namespace enfilade::tasks
