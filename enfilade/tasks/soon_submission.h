/// \file  SOON's submissions, as its own code (github.com/ZhuFengdaaa/SOON) writes and scores them.
#pragma once
#include <string>
#include <vector>

#include "enfilade/tasks/results.h"

namespace enfilade::tasks {

/// [{"instr_id": "7", "trajectory": [{"path": [[viewpoint, heading, elevation], ...],
/// "obj_heading": h, "obj_elevation": e}, ...]}, ...]: an element of the list for each instruction
/// of an entry, with an answer for each of its alternative paths that has a trajectory; null where
/// the agent pointed nowhere. parse_results() reads this form too: an answer is that of the first
/// path of the entry which begins where it does and has none yet; "7_1" names one instruction.
/// What was written is read back equal but for `actions`, if it answers all episodes.
/// \throws ArgumentError if an episode's annotations did not name its entry, as those in DUET's
/// form do not, and for what JSON cannot say
std::string to_released_soon(const std::vector<Trajectory>& trajectories,
                             const EpisodeSet& episodes);

}  // namespace enfilade::tasks
