/// \file  Scoring results of any benchmark by one of its public scorers.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/bootstrap.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/scorer.h"

namespace enfilade::tasks {

/// How results are scored.
struct TaskScoreOptions {
  int threads = 0;               ///< 0: all cores; never changes a result
  int bootstrap_samples = 1000;  ///< 0: no intervals
  std::uint64_t bootstrap_seed = 1;
};

/// What a scorer gives for every episode of a split, and the means.
struct TaskScore {
  std::string split;
  const Scorer* scorer = nullptr;
  TaskScoreOptions options;
  std::vector<double> values;  ///< episodes x metrics, row-major, in the order of the episodes
  /// As the scorer prints them (MeanRule, scale), in the order of its metrics; intervals have the
  /// same scale. Those of MeanRule::kNone are NaN. Episodes that the rule leaves out are out of
  /// intervals, too.
  std::vector<MeanInterval> means;

  std::size_t episodes() const noexcept { return values.size() / scorer->metrics.size(); }
  /// Of an episode, in the order of the scorer's metrics. \pre episode < episodes()
  std::span<const double> row(std::size_t episode) const {
    const std::size_t width = scorer->metrics.size();
    return std::span(values).subspan(episode * width, width);
  }
};

/// Scores one trajectory an episode. The bootstrap draws groups (ReferencePath::group).
/// \throws ArgumentError if the scorer is of another task, if there is not exactly one trajectory
/// an episode, if one is empty or leaves its graph, or for hidden goals
TaskScore compute_task_score(const std::vector<Trajectory>& trajectories,
                             const EpisodeSet& episodes, const Scorer& scorer,
                             const TaskScoreOptions& options = {});

/// The means as a table to read, with the scorer's name and source; of RxR also by language.
std::string to_table(const TaskScore& score, const EpisodeSet& episodes);
/// {"task", "split", "scorer", "source", "episodes": n, "means": {name: {mean, low, high}}}; with
/// `per_episode`, "per_episode": {instr_id: {metric: value}}. What is not finite is null.
std::string to_json(const TaskScore& score, const EpisodeSet& episodes, bool per_episode);

}  // namespace enfilade::tasks
