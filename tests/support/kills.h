/// \file  How often tests kill the programs that they are about.
#pragma once
#include <cstdlib>

namespace enfilade::tests {

/// One, or as many as ENFILADE_KILLS says: 20 before a release, as what a kill finds is rare.
inline int kills() {
  const char* given = std::getenv("ENFILADE_KILLS");
  return given == nullptr ? 1 : std::atoi(given);
}

}  // namespace enfilade::tests
