/// \file  How often tests kill the programs that they are about.
#pragma once
#include <cstdlib>

namespace enfilade::tests {

/// ENFILADE_KILLS=50 is a long run; a few are enough for every day.
inline int kills() {
  constexpr int kEveryDay = 5;
  const char* given = std::getenv("ENFILADE_KILLS");
  return given == nullptr ? kEveryDay : std::atoi(given);
}

}  // namespace enfilade::tests
