/// \file  Pictures and plans of a folder of model homes.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/draw/plan_underlay.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::apps {

/// Draws `homes.png` (a view of each home), `rooms.png` (a view of each type of room),
/// `panoramas.png` (a panorama of each type of room) and `walk.png` (the views along a path, with
/// its instructions, if the folder has paths) into `output`. \returns the names of the files.
/// \throws as homes::read_home_list(), homes::completed(), dataset::Dataset
std::vector<std::string> draw_homes(const std::filesystem::path& homes,
                                    const std::filesystem::path& output);

/// Lines and room names of a model home, for a floor plan, from the folder's list. No value if the
/// folder is no set of model homes or has none of the graph's name. \throws as
/// homes::read_home_list(), homes::completed()
std::optional<draw::PlanUnderlay> home_underlay(const std::filesystem::path& folder,
                                                const graph::NavGraph& graph);

}  // namespace enfilade::apps
