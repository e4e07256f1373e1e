/// \file  Walls and names of rooms for floor plans of model homes.
#pragma once
#include <filesystem>
#include <optional>

#include "enfilade/draw/plan_underlay.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::apps {

/// What stands in a model home, made again from the folder's list (well under a second), and what
/// its rooms are called. Nothing if the folder is no set of model homes or has none of the graph's
/// name. \throws as homes::read_home_list()
std::optional<draw::PlanUnderlay> home_underlay(const std::filesystem::path& folder,
                                                const graph::NavGraph& graph);

}  // namespace enfilade::apps
