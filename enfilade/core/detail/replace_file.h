/// \file  The one way in which whole files are written, and what is done in open folders. Internal.
#pragma once
#include <fcntl.h>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::detail {

/// How a folder is opened in which files are written: its own content need not be readable.
inline constexpr int kOpenFolder = O_PATH | O_DIRECTORY | O_CLOEXEC;

/// Replaces a file, or a link, in an open folder. The content is written to a new temporary file
/// beside it, which is then renamed. Nothing that stands there is written to, no link is followed,
/// and nothing is left after a failure.
/// \param folder  a descriptor  \param shown  the file's path in messages
/// \throws FileError naming `shown` and the system's reason
void replace_file(int folder, const std::string& name, std::string_view content,
                  const std::filesystem::path& shown);

/// Appends the names of all files and folders in an open folder, without "." and "..".
/// \param folder  a descriptor  \returns the system's reason if it cannot be read, else 0
int list_names(int folder, std::vector<std::string>& names);

/// remove_unfinished() of core/file.h in an open folder. \param shown  the folder's path in
/// messages
void remove_unfinished(int folder, std::string_view ending, const std::filesystem::path& shown);

}  // namespace enfilade::detail
