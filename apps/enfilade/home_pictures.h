/// \file  Pictures of a folder of model homes, to look at.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace enfilade::apps {

/// Draws `homes.png` (a view of each home), `rooms.png` (a view of each type of room), and
/// `walk.png` (what one sees along a path, with its instructions, if the folder has paths) into
/// `output`. \returns the names of the files
std::vector<std::string> draw_homes(const std::filesystem::path& homes,
                                    const std::filesystem::path& output);

}  // namespace enfilade::apps
