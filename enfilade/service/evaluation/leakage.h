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
#include <span>
#include <vector>

#include "enfilade/service/phases.h"
#include "enfilade/service/site.h"
#include "enfilade/tasks/scorer.h"

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

/// Bits of a team's row at the end, the best of n submissions; 0 without submissions.
double row_bits(const Phase& phase, std::int64_t submissions);

/// Bits of all answers to a team with n submissions.
/// \param ended whether its row is shown too
/// \returns 0 for open goals, which are not secret, and for kHidden
double team_bits(const Phase& phase, std::int64_t submissions, bool ended);

/// Bits of the most that the phase's limits allow: Phase::teams teams with Phase::per_team
/// submissions each, to the end. +inf without such a limit.
double most_bits(const Phase& phase);

/// Bits of the answers so far. \param submissions per team, those that were scored
double used_bits(const Phase& phase, std::span<const std::int64_t> submissions, bool ended);

/// Bits that describe where all paths end, given the starts: the sum over paths of log2(viewpoints
/// in reach of the path's start, without it). It counts all of them as equally likely; with
/// knowledge of how the paths were drawn, fewer are enough. Other parts of a goal are not counted:
/// objects, regions, turning points, boxes. Continuous episodes count the paths that they follow,
/// each once: they end at viewpoints of the same graphs.
double goal_bits(const tasks::Split& split, const graph::GraphSet& graphs);

/// Which phases share their goals. Immutable: any thread.
class SharedGoals {
 public:
  struct PhaseGroup {
    std::vector<const Phase*> phases;  ///< in the order of Site::phases()
    double goal_bits = 0;              ///< leakage.h
  };

  /// Secret phases share their goals if they name one annotations file, by any path, or one split
  /// of benchmarks that share their paths.
  /// \pre site outlives *this
  explicit SharedGoals(const Site& site);

  /// The group that a phase is in; of open goals it is the phase alone. \pre phase is one of the
  /// site's
  const PhaseGroup& of(const Phase& phase) const;

 private:
  std::vector<PhaseGroup> groups_;
};

}  // namespace enfilade::service::evaluation
