/// \file  Pictures and plans of a folder of model homes.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/draw/plan_underlay.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::apps {

/// Draws `homes.png` (a view of each home), `rooms.png` (a view of each type of room), and
/// `walk.png` (what one sees along a path, with its instructions, if the folder has paths) into
/// `output`. \returns the names of the files
std::vector<std::string> draw_homes(const std::filesystem::path& homes,
                                    const std::filesystem::path& output);

/// What stands in a model home, by the folder's list, and what its rooms are called: for a floor
/// plan. Nothing if the folder is no set of model homes or has none of the graph's name. \throws as
/// homes::read_home_list(), homes::completed()
std::optional<draw::PlanUnderlay> home_underlay(const std::filesystem::path& folder,
                                                const graph::NavGraph& graph);

}  // namespace enfilade::apps
