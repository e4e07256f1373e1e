/// \file  Which Enfilade made a page.
#pragma once
#include <string>

namespace enfilade::apps {

/// "0.3.0, commit 0123456789ab"; only the version if the sources are not a clone.
std::string version_with_commit();

}  // namespace enfilade::apps
