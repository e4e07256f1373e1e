/// \file  How much a phase gives away of its secret goals, as upper bounds in bits. Pure functions
/// of a phase and of counts; any thread. docs/design/secret_goals.md has the reasons.
///
/// Derivation. Submitters may cooperate, and may use random numbers. They learn of the goals only
/// by the server's answers, as they have the files themselves. Let there be at most K different
/// sequences of answers. Then the answers carry at most log2 K bits: I(goals; answers) <=
/// H(answers) <= log2 K. So it is enough to count:
/// - nothing is shown (kHidden; kAfterEnd before the end): the answers are the same for all goals,
///   K = 1;
/// - a ladder of n scored submissions shows a best score that never falls and has L values. There
///   are K = C(n + L - 1, n) sequences of n values that never fall;
/// - a team's row at the end shows the best of its n submissions (n ways), and each metric by a
///   value of its grid;
/// - answers to several teams, and in several phases, multiply: their bits add up.
///
/// Left out, as they are not answers: the time that answers take, and communication between people.
#pragma once
#include <cstdint>

#include "enfilade/graph/graph_set.h"
#include "enfilade/service/phases.h"
#include "enfilade/tasks/scorer.h"
#include "enfilade/tasks/split.h"

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

/// Bits of a ladder that shows at most `levels` scores to a team with n submissions: log2 C(n +
/// levels - 1, n).
/// \pre levels >= 1, submissions >= 0
double ladder_bits(std::int64_t submissions, std::int64_t levels);

/// Bits of a row of means at the end, without the choice of its submission.
double means_bits(const Phase& phase);
/// Bits of a team's row, the best of n submissions; 0 without submissions.
double row_bits(double of_means, std::int64_t submissions);

/// Bits of all answers to a team with n submissions.
/// \param ended whether its row is shown too
/// \returns 0 for open goals, which are not secret, and for kHidden
double team_bits(const Phase& phase, std::int64_t submissions, bool ended);

/// Bits of the most that the phase's limits allow: Phase::teams teams with Phase::per_team
/// submissions each, to the end. +inf without such a limit.
double most_bits(const Phase& phase);

/// Bits that describe where paths end, at least: the sum over different starts of log2(viewpoints
/// in reach of the start, without it). So it depends on public data alone, and entries of one path
/// (RxR) or game (CVDN) count once. It counts all viewpoints as equally likely; with knowledge of
/// how the paths were drawn, fewer are enough. Other parts of a goal are not counted: objects,
/// regions, turning points, boxes.
double goal_bits(const tasks::Split& split, const graph::GraphSet& graphs);

}  // namespace enfilade::service::evaluation
