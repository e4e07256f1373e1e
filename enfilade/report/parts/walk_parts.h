/// \file  The part of the page that shows continuous trajectories.
#pragma once
#include <cstddef>
#include <nlohmann/json_fwd.hpp>

#include "enfilade/report/continuous_runs.h"

namespace enfilade::report::parts {

/// Maps from above of a split's episodes with the trajectories of all agents' first runs. Shows
/// `of_a_kind` best, worst and median ones of the last agent that is not an oracle. The split is
/// val_unseen, if there is a run on it.
nlohmann::ordered_json walks_part(const ContinuousRuns& runs, std::size_t of_a_kind,
                                  bool synthetic);

}  // namespace enfilade::report::parts
