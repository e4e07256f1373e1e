/// \file  The part of the page that shows walks in continuous space.
#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>

#include "enfilade/report/scored_runs.h"

namespace enfilade::report::parts {

/// Maps from above of a split's episodes with all agents' walks, of each agent its first run: so
/// many best, worst and median ones of the last agent that is no oracle. Of val_unseen, if there is
/// a run on it.
nlohmann::ordered_json walks_part(const ScoredRuns& runs, std::size_t of_a_kind, bool synthetic);

}  // namespace enfilade::report::parts
