/// \file  Whole files in and out.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace enfilade {

/// \throws FileError naming the path and the system's reason; a folder is not a file.
std::string read_file(const std::filesystem::path& path);

/// Writes beside the target and renames over it: readers see the old content or the new, never a
/// half, also when the process is killed. A link is followed, and what is not a plain file (a pipe,
/// /dev/stdout) is written to directly.
/// \throws FileError naming the path and the system's reason (no such folder, disk full, ...).
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

/// Makes a folder and those that it lies in; nothing happens if it is there.
/// \throws FileError naming the path and the system's reason (a file of this name, ...).
void make_folder(const std::filesystem::path& path);

/// Removes what write_file_atomically() leaves in a folder, not in those below, when its process is
/// killed; a folder that is not there has none. \pre nobody is writing there
void remove_unfinished(const std::filesystem::path& folder);

}  // namespace enfilade
