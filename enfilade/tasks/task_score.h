/// \file  Scoring results of any benchmark by one of its public scorers.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/bootstrap.h"
#include "enfilade/tasks/public_scorer.h"
#include "enfilade/tasks/results.h"

namespace enfilade::tasks {

/// How results are scored.
struct TaskScoreOptions {
  int threads = 0;               ///< 0: all cores; never changes a result
  int bootstrap_samples = 1000;  ///< 0: no intervals
  std::uint64_t bootstrap_seed = 1;
};

/// A scorer's values for every episode of a split, and the means.
struct TaskScore {
  std::string split;
  const PublicScorer* scorer = nullptr;
  TaskScoreOptions options;
  std::vector<double> values;  ///< episodes x metrics, row-major, in the order of the episodes.
  /// Means by MeanRule and scale, in the order of the metrics; intervals have the same scale. Those
  /// of MeanRule::kNone are NaN. Intervals leave out the same episodes as the rule.
  std::vector<MeanInterval> means;

  std::size_t episodes() const noexcept { return values.size() / scorer->metrics.size(); }
  /// The values of an episode, in the order of the scorer's metrics. \pre episode < episodes()
  std::span<const double> row(std::size_t episode) const {
    const std::size_t width = scorer->metrics.size();
    return std::span(values).subspan(episode * width, width);
  }
};

/// Scores one trajectory per episode. The bootstrap draws groups (ReferencePath::group).
/// \throws ArgumentError if the scorer is of another task, unless each episode has one trajectory,
/// if one is empty or leaves its graph, or for hidden goals
TaskScore compute_task_score(const std::vector<Trajectory>& trajectories,
                             const EpisodeSet& episodes, const PublicScorer& scorer,
                             const TaskScoreOptions& options = {});

/// The means as a table to read, with the scorer's name and source; of RxR also by language.
std::string to_table(const TaskScore& score, const EpisodeSet& episodes);
/// {"task", "split", "scorer", "source", "episodes": n, "means": {name: {mean, low, high}}}; with
/// `per_episode`, "per_episode": {instr_id: {metric: value}}. A number that is not finite is null.
std::string to_json(const TaskScore& score, const EpisodeSet& episodes, bool per_episode);

}  // namespace enfilade::tasks
