/// \file  Scores as the public code of each benchmark gives them, by the name of that code. Where
/// two disagree, both are here. Formulas: docs/tasks.md.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/graph/nav_graph.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/goal.h"
#include "enfilade/tasks/results.h"

namespace enfilade::tasks {

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
  const char* mean = nullptr;  ///< its name of the mean: "lengths"; null: as the metric
  MeanRule rule = MeanRule::kPlain;
  double scale = 1;  ///< of the mean: 100 where the scorer prints per cent
  const char* mean_name() const noexcept { return mean == nullptr ? name : mean; }
};

/// The code that scored a benchmark's published results.
struct PublicScorer {
  Task task;
  std::string_view name;    ///< "official", "duet", "hamt", "valan", "r4r_public", ...
  std::string_view source;  ///< repository and revision that it was compared with
  std::span<const ScorerMetric> metrics;
  /// The metrics of one trajectory, in their order. NaN where the code divides by zero, fails, or
  /// has no value: a move without a required edge, no box at the last viewpoint.
  /// \pre the goal is not hidden and of the task's kind; the trajectory is not empty and stays in
  /// the graph; out.size() == metrics.size()
  void (*score)(const graph::NavGraph& graph, const ReferencePath& reference,
                const Trajectory& trajectory, std::span<double> out);
};

/// All, those of a task one after the other, the one behind the published tables first.
std::span<const PublicScorer> public_scorers() noexcept;
/// Those of a task. \pre there is one
std::span<const PublicScorer> public_scorers(Task task) noexcept;
/// By name. \throws LookupError naming those that there are
const PublicScorer& public_scorer(Task task, std::string_view name);

/// The scorer's summary of a set of trajectories: the mean of each metric by its rule and scale.
/// NaN for MeanRule::kNone, and for no trajectory.
/// \param values  n x metrics, row-major
std::vector<double> summarise(const PublicScorer& scorer, std::span<const double> values);

}  // namespace enfilade::tasks
