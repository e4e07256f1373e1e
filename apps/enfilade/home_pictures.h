/// \file  Pictures and plans of a folder of synthetic homes; progress of making one.
#pragma once
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/draw/plan_underlay.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/homes/home_set.h"

namespace enfilade::apps {

/// A progress_bar() for homes::write_homes() and write_home_paths().
homes::SetProgress set_bar(const std::string& what);

/// Renders pictures of homes into `output`: `homes.png` has a view of each home, `rooms.png` a view
/// and `panoramas.png` a panorama of each type of room. If the folder has paths, `walk.png` has the
/// views along a path, with its instructions.
/// \returns the names of the files
/// \throws as homes::read_home_list(), homes::completed(), dataset::Dataset
std::vector<std::string> draw_homes(const std::filesystem::path& homes,
                                    const std::filesystem::path& output);

/// Lines and room names of a synthetic home, for a floor plan, from the folder's list. No value if
/// the folder is not a set of homes or has none of the graph's name.
/// \throws as homes::read_home_list(), homes::completed()
std::optional<draw::PlanUnderlay> home_underlay(const std::filesystem::path& folder,
                                                const graph::NavGraph& graph);

}  // namespace enfilade::apps
