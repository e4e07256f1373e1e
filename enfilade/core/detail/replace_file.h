/// \file  The one way in which whole files are written. Internal.
#pragma once
#include <fcntl.h>
#include <filesystem>
#include <string>
#include <string_view>

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

}  // namespace enfilade::detail
