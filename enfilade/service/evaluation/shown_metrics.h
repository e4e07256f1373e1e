/// \file  How coarsely a leaderboard's means are shown where goals are secret. What is shown
/// (leaderboard.h) and what that gives away (leakage.h) are both computed from here.
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
  /// The nearest one: an end for what is beyond it, or infinite; `least` for what is no number.
  double round(double value) const;
};

/// What a mean over secret goals is rounded to: shares to the phase's step, metres to ten times as
/// many metres, at most 30 (of progress also -30 at least). \pre measure.tells_goals
Grid grid_of(const Phase& phase, const tasks::Measure& measure);

}  // namespace enfilade::service::evaluation
