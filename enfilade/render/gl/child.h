/// \file  Running a program that may crash or hang.
#pragma once
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace enfilade::render::gl {

/// How such a program ended.
struct ChildEnd {
  enum class How {
    kExited,      ///< by itself; code: its exit status, or -1 if somebody else asked for it first
    kKilled,      ///< code: the signal
    kSilent,      ///< it printed nothing for too long, and was killed
    kNotStarted,  ///< code: errno; ENOENT where the system does not say
  };
  How how = How::kNotStarted;
  int code = 0;
};

/// Runs a program and waits for its end. It has no input, its errors go nowhere, and no handler or
/// mask of signals is left to it. Safe with any number of threads, as nothing of this process but
/// its environment goes into the other.
/// \param command file and arguments \param seconds until a line must come that counts, each time
/// \param line called with each line that it prints; returns whether it counts
ChildEnd run_child(const std::vector<std::string>& command, double seconds,
                   const std::function<bool(std::string_view)>& line);

}  // namespace enfilade::render::gl
