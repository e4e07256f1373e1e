/// \file  Opens a page in the local browser.
#pragma once
#include <filesystem>

namespace enfilade::apps {

/// Shows a file in the browser that BROWSER names, or in the desktop's (xdg-open). Does not wait
/// for it.
/// \returns false if there is none, as in a container or over ssh
bool open_page(const std::filesystem::path& file);

}  // namespace enfilade::apps
