/// \file  A continuous episode by its id, and trajectories of it.
#pragma once
#include <memory>
#include <string>

#include "apps/common/program.h"
#include "enfilade/agents/continuous_setup.h"
#include "enfilade/continuous/buildings.h"
#include "enfilade/tasks/continuous_results.h"

namespace enfilade::apps {

/// Nothing if there is no such id. Valid as long as `episodes`.
const tasks::ContinuousEpisode* find_episode(const tasks::ContinuousEpisodes& episodes,
                                             const std::string& id);
/// The trajectory of one of `episodes` in a results file.
/// \throws UsageError if it has none; as tasks::load_continuous_results()
tasks::ContinuousResult walk_of(const std::string& results,
                                const tasks::ContinuousEpisodes& episodes,
                                const tasks::ContinuousEpisode& episode);

}  // namespace enfilade::apps
