/// \file  How much a phase gives away of its secret goals, as upper bounds in bits. Pure functions
/// of a phase and of counts; any thread. docs/design/secret_goals.md has the reasons.
///
/// Derivation. Whoever submits, alone or together, however cleverly, and with any chance of their
/// own, learns of the goals only by what the server answers; the files themselves they know. Let
/// there be at most K different sequences of answers. Then the answers carry at most log2 K bits:
/// I(goals; answers) <= H(answers) <= log2 K. So it is enough to count:
/// - nothing is shown (kHidden; kAfterEnd before the end): the answers are the same for all goals,
///   K = 1;
/// - a ladder of n scored submissions shows a best score that never falls and has L values: there
///   are K = C(n + L - 1, n) sequences of n values that never fall;
/// - the row of a team at the end says which of its n submissions was the best (n ways), and each
///   metric by one of the values of its grid;
/// - answers to several teams, and in several phases, multiply: their bits add up.
/// Left out, as they are no answers: the time that answers take, and what people tell people.
#pragma once
#include <cstdint>
#include <span>

#include "enfilade/service/site.h"

namespace enfilade::service::evaluation {

/// Of a ladder that shows at most `levels` scores to a team with n submissions: log2 C(n + levels -
/// 1, n). \pre levels >= 1, submissions >= 0
double ladder_bits(std::int64_t submissions, std::int64_t levels);

/// Of a team's row at the end, the best of n submissions; 0 for none.
double row_bits(const Phase& phase, std::int64_t submissions);

/// Of all answers to a team with n submissions. \param ended whether its row is shown too
/// \returns 0 for open goals, which are no secret, and for kHidden
double team_bits(const Phase& phase, std::int64_t submissions, bool ended);

/// Of all that the phase's limits allow: Phase::teams teams with Phase::per_team submissions each,
/// to the end. +inf without such a limit.
double most_bits(const Phase& phase);

/// Of what was answered so far. \param submissions of each team, those that were scored
double used_bits(const Phase& phase, std::span<const std::int64_t> submissions, bool ended);

/// What it takes to write down where all paths end, for somebody who knows the starts: the sum over
/// paths of log2(viewpoints that the path could end at: those in reach of its start, without it).
/// It counts all of them as equally likely; whoever knows how the paths were drawn needs less. What
/// else a goal has is not counted: objects, regions, turning points, boxes. Of continuous episodes
/// as many as of the paths that they follow, each once: they end at viewpoints of the same graphs.
/// \param graphs of all scans
double goal_bits(const SecretEpisodes& episodes, const graph::GraphSet& graphs);

}  // namespace enfilade::service::evaluation
