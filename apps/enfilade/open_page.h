/// \file  A page in the browser of whoever sits at this machine.
#pragma once
#include <filesystem>

namespace enfilade::apps {

/// Shows a file in the browser that BROWSER names, or that the desktop has (xdg-open), and does not
/// wait for it. \returns false where there is none, as in a container or over ssh
bool open_page(const std::filesystem::path& file);

}  // namespace enfilade::apps
