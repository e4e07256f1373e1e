/// \file  Columns of tables and leaderboards per benchmark, with their titles, units and
/// directions, and the one that ranks.
#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/tasks/goal.h"

namespace enfilade::tasks {

enum class ContinuousForm : std::uint8_t;

/// The unit of a measure.
enum class Unit : std::uint8_t { kMetres, kShare };

/// Which values of a measure are the better ones.
enum class Better : std::uint8_t { kHigher, kLower, kNeither };

/// A mean over the episodes of a split, as a column of a table.
struct Measure {
  const char* name;    ///< in "means" of to_json(Score) and to_json(TaskScore): "spl", "nDTW"
  const char* column;  ///< short: "SPL"
  const char* title;   ///< "Success weighted by path length"
  Unit unit = Unit::kShare;
  Better better = Better::kHigher;
  /// The scorer's value for a share of one: 100 if it prints per cent. Divide a mean by it to get a
  /// share. 1 for metres.
  double whole = 1;
  /// Whether goals or reference paths have a part in it. Otherwise it depends only on the
  /// trajectory.
  bool tells_goals = true;
};

/// The name of R2R's table of our own (score.h) among the scorers.
inline constexpr std::string_view kOwnScorer = "enfilade";

/// Names of a task's scorers, the default first: of R2R kOwnScorer, else the one behind the
/// published tables.
std::vector<std::string_view> scorer_names(Task task);

/// The columns of the task's default scorer; the first is the headline, by which leaderboards rank.
/// Each headline is a share, or metres of progress, and better where higher.
std::span<const Measure> measures(Task task) noexcept;
/// The same of a scorer by name. \throws LookupError naming those that there are
std::span<const Measure> measures(Task task, std::string_view scorer);

/// The scorer of continuous trajectories (continuous_score.h).
inline constexpr std::string_view kContinuousScorer = "vlnce";

/// Leaderboard columns of continuous benchmarks, by names of continuous_measures(). The first is
/// the headline: SPL, and nDTW for RxR-CE, as in its challenge.
std::span<const Measure> measures(ContinuousForm form) noexcept;

/// The first of measures(task).
inline const Measure& headline(Task task) noexcept { return measures(task).front(); }

/// By Measure::name; null if the name is unknown.
const Measure* find_measure(std::span<const Measure> measures, std::string_view name) noexcept;

}  // namespace enfilade::tasks
