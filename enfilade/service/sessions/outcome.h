/// \file  The outcome of a finished episode whose goal is open.
#pragma once
#include <nlohmann/json_fwd.hpp>

#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"

namespace enfilade::service::sessions {

/// A trajectory judged by tasks::judge(), as JSON:
/// - "scan"
/// - "kind": detail::name_of_kind() of the goal
/// - "path": the viewpoint ids of the reference path
/// - "walk": those of the trajectory, turns on the spot left out
/// - "viewpoints": those where the goal's object, region or turning point is; else empty
/// - "length", "shortest", "error", "oracle_error": metres; null where the goal is out of reach
/// - "success", "oracle_success": whether the goal was reached at the end, or on the way
/// - "success_distance": metres
/// - "answer": of REVERIE, whether the named object is the goal's, null without one; else left out
///
/// Any thread. \pre the trajectory's episode is one of the set's, and its goal is not hidden; the
/// trajectory is not empty
nlohmann::ordered_json outcome_json(const tasks::EpisodeSet& episodes,
                                    const tasks::Trajectory& trajectory);

}  // namespace enfilade::service::sessions
