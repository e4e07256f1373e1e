/// \file  Columns of tables and leaderboards, with their titles, units and directions.
#pragma once
#include <cstdint>
#include <span>
#include <string_view>

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

}  // namespace enfilade::tasks
