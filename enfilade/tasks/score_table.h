/// \file  Scored results as a table: a row per episode, a column per metric of the scorer, and the
/// mean of each column with its interval. One type for both worlds and every scorer.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/bootstrap.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/scorer.h"

namespace enfilade::tasks {

/// How results are scored.
struct ScoreOptions {
  MetricOptions metrics = {};    ///< of own_scorer() only
  int threads = 0;               ///< 0: all cores; never changes a result
  int bootstrap_samples = 1000;  ///< 0: no intervals
  std::uint64_t bootstrap_seed = 1;
};

/// What a scorer gives for every episode of a split, and the means.
struct ScoreTable {
  const Benchmark* benchmark = nullptr;
  const Scorer* scorer = nullptr;
  std::string split;
  ScoreOptions options = {};     ///< what it was made with
  std::size_t episodes = 0;      ///< n
  std::size_t groups = 0;        ///< how many of them the bootstrap drew from
  std::vector<double> values;    ///< (n, metrics), row-major; empty if from_json() found none
  std::vector<std::string> ids;  ///< of the episodes, (n); likewise
  std::vector<std::string> languages = {};  ///< (n); empty if the benchmark has none
  /// The floor of the distances, for continuous space: "enfilade" or "habitat 0.3.3".
  std::string floor = {};
  /// As the scorer prints them (MeanRule, scale), in the order of its metrics; intervals of 95 %
  /// have the same scale. Those of MeanRule::kNone are NaN. Episodes that the rule leaves out are
  /// out of intervals, too.
  std::vector<MeanInterval> means;

  /// By the name of the mean ("success"). \throws LookupError listing the names
  const MeanInterval& mean(std::string_view name) const { return means[scorer->place_of(name)]; }
  /// An episode's values, in the order of the scorer's metrics. \pre episode < n, values are there
  std::span<const double> row(std::size_t episode) const {
    const std::size_t width = scorer->metrics.size();
    return std::span(values).subspan(episode * width, width);
  }
  /// One of them, by the name of its mean. \throws as mean()
  double value(std::size_t episode, std::string_view name) const {
    return row(episode)[scorer->place_of(name)];
  }
};

/// A row of own_scorer() as a value. \pre the table is of it
EpisodeMetrics metrics_of(const ScoreTable& table, std::size_t episode);

/// The metrics of every trajectory by its episode's goal, in their order, on all cores.
/// \throws ArgumentError if a trajectory names no episode, is empty or leaves its graph, if a goal
/// is hidden, or for a success distance that isn't positive
std::vector<EpisodeMetrics> score_trajectories(const std::vector<Trajectory>& trajectories,
                                               const EpisodeSet& episodes,
                                               const MetricOptions& options, int threads);

/// Scores one trajectory per episode; rows are in the order of the episodes. The bootstrap draws
/// groups (ReferencePath::group), such as a path with its three instructions, because those are no
/// independent samples (docs/design/bootstrap.md).
/// \throws ArgumentError if the scorer is of another task, or unless each episode has exactly one
/// trajectory; as score_trajectories()
ScoreTable compute_score(const std::vector<Trajectory>& trajectories, const EpisodeSet& episodes,
                         const Scorer& scorer, const ScoreOptions& options = {});
/// By the benchmark's default scorer.
ScoreTable compute_score(const std::vector<Trajectory>& trajectories, const EpisodeSet& episodes,
                         const ScoreOptions& options = {});
/// The same of a results file.
inline ScoreTable compute_score(const Results& results, const EpisodeSet& episodes,
                                const ScoreOptions& options = {}) {
  return compute_score(results.trajectories, episodes, options);
}
/// The table of walks in continuous space; rows are in their order. The bootstrap draws
/// trajectories. agents::compute_score() computes the values too.
/// \param values  of the scorer's metrics, (walks, metrics), row-major
/// \throws ArgumentError for no walk, or for another number of values
ScoreTable make_score_table(const Benchmark& benchmark, const Scorer& scorer,
                            std::span<const ContinuousResult> walks,
                            const ContinuousEpisodes& episodes, std::vector<double> values,
                            const ScoreOptions& options = {});

/// Whether a path's goal is hidden, so that the split can be run but not scored.
bool goals_hidden(const EpisodeSet& episodes) noexcept;

/// \name JSON
/// "split", "episodes": n, "means": {name: {"mean", "low", "high"}}, each without an interval if
/// there was no bootstrap; with `per_episode` "per_episode": {id: {metric: value}}. Public scorers
/// add "task", "scorer" and "source", own_scorer() adds "options", continuous space
/// "trajectories" (groups) and "floor". What is not finite is null.
/// @{

/// The JSON of a table. \param per_episode  whether it has the values of each episode
std::string to_json(const ScoreTable& table, bool per_episode = false);
/// One line for a database: as to_json(), always with "task" and "scorer".
std::string to_record(const ScoreTable& table);
/// Reads any of these back. Without "scorer": own_scorer() on R2R, "vlnce" on R2R-CE if there are
/// "trajectories". null becomes NaN.
/// \throws LookupError for an unknown benchmark or scorer; InvalidInput for other JSON
ScoreTable from_json(std::string_view json);
/// @}

/// Which of the two SPLs a table of own_scorer() shows.
enum class SplLength {
  kShortest,   ///< of the shortest path to the goal (Anderson et al. 2018b)
  kReference,  ///< of the reference path, as DUET evaluates
};
/// A table to read.
/// - own_scorer(): TL NE SR OSR SPL nDTW sDTW CLS steps, shares in per cent. nDTW and sDTW are the
///   collapsed ones (docs/design/dtw-of-turns.md).
/// - Public scorers: their names for the means, with the source; by language too where there are
///   any.
std::string to_table(const ScoreTable& table, SplLength spl = SplLength::kShortest);

}  // namespace enfilade::tasks
