/// \file  Reading and writing whole files.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace enfilade {

/// Largest size of a file that is read whole.
inline constexpr std::size_t kMostFileBytes = std::size_t{1} << 32U;
/// The same of a device, which may have no end.
inline constexpr std::size_t kMostDeviceBytes = std::size_t{1} << 26U;

/// The content of a file. A pipe is read to its end.
/// \param most  bytes; of a device at most kMostDeviceBytes
/// \throws FileError naming the path and the system's reason. Also for a folder, for more than
/// `most` bytes, and for a pipe that no program writes to within 2 s
std::string read_file(const std::filesystem::path& path, std::size_t most = kMostFileBytes);

/// Refuses a folder, pipe or device before a library opens it. A pipe may block for ever, and a
/// device may have no end. \throws FileError naming the path
void check_plain_file(const std::filesystem::path& path);

/// Whether there is a file or folder of that name; links are followed.
/// \throws FileError naming the path and the system's reason if that cannot be found out
bool file_exists(const std::filesystem::path& path);

/// Replaces the content of a file that a user named; OutputFolder is for computed names. Writes a
/// new temporary file beside it and renames that. Readers see the old content or the new, never a
/// part, even if the process is killed. If `path` is a link, its target is written. Pipes and
/// devices such as /dev/stdout are written directly.
/// \throws FileError naming the path and the system's reason (no such folder, disk full, ...).
void write_file_atomically(const std::filesystem::path& path, std::string_view content);

/// Makes a folder and its parents. Does nothing if it exists.
/// \throws FileError naming the path and the system's reason (a file of this name, ...).
void make_folder(const std::filesystem::path& path);

/// Whether the name is one of write_file_atomically()'s temporary files: "homes.json.part4711".
bool is_unfinished(const std::filesystem::path& path);

/// Removes the temporary files that write_file_atomically() and OutputFolder leave in a folder (not
/// in its subfolders) if their process is killed. Those of a process that runs stay. The folder
/// need not exist.
/// \pre no process of another machine, nor another thread, is writing there
/// \param ending  only of files whose names end with it; empty: of all files
/// \throws FileError naming a file that cannot be removed
void remove_unfinished(const std::filesystem::path& folder, std::string_view ending = {});

}  // namespace enfilade
