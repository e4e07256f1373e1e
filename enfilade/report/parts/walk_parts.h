/// \file  The part of the page that shows walks in continuous space.
#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>

#include "enfilade/report/scored_runs.h"

namespace enfilade::report::parts {

/// Maps from above of a split's episodes, with the trajectories of each agent's first run. The
/// split is val_unseen if there is a run on it. Shown are the best, worst and median episodes of
/// the last agent that is no oracle.
/// \param of_a_kind  number of episodes of each kind
nlohmann::ordered_json walks_part(const ScoredRuns& runs, std::size_t of_a_kind, bool synthetic);

}  // namespace enfilade::report::parts
