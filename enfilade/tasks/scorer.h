/// \file  Scorers by name: those of the public code of each benchmark, and Enfilade's own. Where
/// two disagree, both are here. Formulas: docs/tasks.md.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/continuous_score.h"
#include "enfilade/tasks/goal.h"
#include "enfilade/tasks/metrics.h"
#include "enfilade/tasks/results.h"

namespace enfilade::tasks {

/// What a measure counts.
enum class Unit : std::uint8_t { kMetres, kShare };

/// Which values of a measure are the better ones.
enum class Better : std::uint8_t { kHigher, kLower, kNeither };

/// A mean over the episodes of a split, as a column of a table.
struct Measure {
  const char* name;    ///< what its scorer calls the mean: "spl", "nDTW"
  const char* column;  ///< short: "SPL"
  const char* title;   ///< "Success weighted by path length"
  Unit unit = Unit::kShare;
  Better better = Better::kHigher;
  /// What the scorer prints for a share of one: 100 where it prints per cent. Divide a mean by it
  /// to get a share. 1 for metres.
  double whole = 1;
  /// Whether goals or reference paths have a part in it; without them it tells what an agent
  /// walked, and no more.
  bool tells_goals = true;
};

/// By Measure::name; null if there is none.
const Measure* find_measure(std::span<const Measure> measures, std::string_view name) noexcept;

/// How a scorer takes the mean of a metric over episodes.
enum class MeanRule : std::uint8_t {
  kNone,          ///< it does not
  kPlain,         ///< sum / n; NaN if any value is
  kWhereDefined,  ///< over the episodes whose value is not NaN
  kGuarded,       ///< sum / (n + 1e-9)
};

/// A number that a scorer gives for an episode.
struct ScorerMetric {
  const char* name = nullptr;  ///< as the scorer calls it: "trajectory_lengths"
  const char* mean = nullptr;  ///< what it calls the mean: "lengths"; null: as the metric
  MeanRule rule = MeanRule::kPlain;
  double scale = 1;  ///< of the mean: 100 where the scorer prints per cent
  constexpr const char* mean_name() const noexcept { return mean == nullptr ? name : mean; }
};

/// What a scorer of a benchmark on graphs computes from.
/// \pre the goal is not hidden and of the scorer's task; the trajectory is not empty and stays in
/// the graph
struct ScoredTrajectory {
  const graph::NavGraph& graph;
  const ReferencePath& reference;
  const Trajectory& trajectory;
  MetricOptions options = {};  ///< public scorers have their own
};

/// One way to score results.
struct Scorer {
  std::string_view name;    ///< "enfilade", "official", "duet", "vlnce", "etpnav", ...
  std::string_view source;  ///< repository and commit that its results were compared with
  std::span<const ScorerMetric> metrics;
  /// What tables and leaderboards show, by the names of means; the first is the headline. Empty for
  /// one that no leaderboard has.
  std::span<const Measure> columns = {};
  /// \name The metrics of one episode, in their order: one of the two is set
  ///
  /// A metric is NaN where the code divides by zero, fails, or has no value. It has none for a move
  /// without an edge where it requires edges, or without a box at the last viewpoint.
  /// \pre out.size() == metrics.size()
  /// @{
  void (*on_graph)(const ScoredTrajectory& scored, std::span<double> out) = nullptr;
  void (*on_floor)(const ContinuousWalk& walk, std::span<const Point3> reference,
                   std::span<double> out) = nullptr;
  /// @}
  /// The only benchmark whose goals it reads; none: any on graphs, or any in continuous space.
  std::optional<Task> task = {};

  /// The place of a metric by the name of its mean. \throws LookupError listing the names
  std::size_t place_of(std::string_view mean_name) const;
};

/// Enfilade's own metrics (metrics.h), by the goal that there is (goal_distance.h): R2R's default.
inline constexpr std::string_view kOwnScorer = "enfilade";
/// It, for a benchmark of any goal on graphs.
const Scorer& own_scorer() noexcept;

/// What the scorer prints for a set of episodes: the mean of each metric by its rule and scale.
/// NaN for MeanRule::kNone, and for no episode. \param values  n x metrics, row-major
std::vector<double> summarise(const Scorer& scorer, std::span<const double> values);

}  // namespace enfilade::tasks
