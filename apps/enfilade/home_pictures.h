/// \file  Pictures of a folder of synthetic homes; progress of making one.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

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

}  // namespace enfilade::apps
