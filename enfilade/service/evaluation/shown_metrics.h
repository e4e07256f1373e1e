/// \file  The metrics of the leaderboard, and how coarsely they are shown where goals are secret.
/// What is shown (leaderboard.h) and what that gives away (leakage.h) are both computed from here.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>

#include "enfilade/service/phases.h"

namespace enfilade::service::evaluation {

/// What the mean of a metric is.
enum class Quantity : std::uint8_t {
  kWalked,   ///< metres of the trajectory itself: whoever made it knows them, they tell no goal
  kToGoal,   ///< metres to the goal
  kOfGoals,  ///< a share from 0 to 1 that depends on goals or references
};

struct ShownMetric {
  const char* name;  ///< of tasks::metric_fields()
  Quantity quantity;
};

/// The leaderboard's columns, in their order.
inline constexpr std::array<ShownMetric, 8> kShownMetrics{{{"trajectory_length", Quantity::kWalked},
                                                           {"nav_error", Quantity::kToGoal},
                                                           {"success", Quantity::kOfGoals},
                                                           {"oracle_success", Quantity::kOfGoals},
                                                           {"spl", Quantity::kOfGoals},
                                                           {"ndtw_collapsed", Quantity::kOfGoals},
                                                           {"sdtw_collapsed", Quantity::kOfGoals},
                                                           {"cls", Quantity::kOfGoals}}};

/// Multiples of `step` from 0 to `most`.
struct Grid {
  double step = 0;
  double most = 0;

  /// How many values there are.
  std::int64_t levels() const;
  /// The nearest one: `most` for what is larger, or infinite.
  double round(double value) const;
};

/// What a mean over secret goals is rounded to: shares to the phase's step, metres to ten times as
/// many metres, at most 30. \pre the quantity is not kWalked
Grid grid_of(const Phase& phase, Quantity quantity);

}  // namespace enfilade::service::evaluation
