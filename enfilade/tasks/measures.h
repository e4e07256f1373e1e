/// \file  What tables and leaderboards show of each benchmark: columns with their titles, units and
/// directions, and the one that ranks.
#pragma once
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/tasks/goal.h"

namespace enfilade::tasks {

enum class ContinuousForm : std::uint8_t;

/// What a measure counts.
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
  /// What the scorer prints for a share of one: 100 where it prints per cent. Divide a mean by it
  /// to get a share. 1 for metres.
  double whole = 1;
  /// Whether goals or reference paths have a part in it; without them it tells what an agent
  /// walked, and no more.
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

/// The scorer of walks in continuous space (continuous_score.h).
inline constexpr std::string_view kContinuousScorer = "vlnce";

/// What leaderboards show of walks in continuous space, by names of continuous_measures(). The
/// first is the headline: SPL, and nDTW of RxR-CE, as its challenge ranked.
std::span<const Measure> measures(ContinuousForm form) noexcept;

/// The first of measures(task).
inline const Measure& headline(Task task) noexcept { return measures(task).front(); }

/// By Measure::name; null if there is none.
const Measure* find_measure(std::span<const Measure> measures, std::string_view name) noexcept;

}  // namespace enfilade::tasks
