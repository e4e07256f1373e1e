/// \file  SOON's submissions, as its own code (github.com/ZhuFengdaaa/SOON) writes and scores them.
#pragma once
#include <string>
#include <vector>

#include "enfilade/tasks/results.h"

namespace enfilade::tasks {

/// Writes [{"instr_id": "7", "trajectory": [{"path": [[viewpoint, heading, elevation], ...],
/// "obj_heading": h, "obj_elevation": e}, ...]}, ...]. Each instruction of an entry is an element
/// of the list. It has an answer for each of its alternative paths that has a trajectory; null if
/// the agent gave no direction.
///
/// parse_results() reads this form too. An answer is that of the first path of the entry which
/// begins where it does and has none yet; "7_1" names one instruction. If all episodes have
/// answers, the text is read back equal except `actions`.
/// \throws ArgumentError if an episode's annotations did not name its entry, as those in DUET's
/// form do not; for infinite numbers and text that is not UTF-8
std::string to_released_soon(const std::vector<Trajectory>& trajectories,
                             const EpisodeSet& episodes);

}  // namespace enfilade::tasks
