/// \file  Rounding of a leaderboard's means with secret goals. Both the shown values
/// (leaderboard.h) and their leakage (leakage.h) are computed from it.
#pragma once
#include <cstdint>

#include "enfilade/service/phases.h"
#include "enfilade/tasks/measures.h"

namespace enfilade::service::evaluation {

/// Multiples of `step` from `least` to `most`.
struct Grid {
  double step = 0;
  double most = 0;
  double least = 0;

  /// How many values there are.
  std::int64_t levels() const;
  /// The nearest one: an end for values beyond it, or infinite; `least` for NaN.
  double round(double value) const;
};

/// The grid of a mean over secret goals. Shares are rounded to the phase's step, metres to ten
/// times as many metres, at most 30 (progress also at least -30).
/// \pre measure.tells_goals
Grid grid_of(const Phase& phase, const tasks::Measure& measure);

}  // namespace enfilade::service::evaluation
