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
    kExited,      ///< by itself; code: its exit status, -1 if already collected
    kKilled,      ///< code: the signal
    kSilent,      ///< it printed nothing for too long, and was killed
    kNotStarted,  ///< code: errno; ENOENT where the system does not say
  };
  How how = How::kNotStarted;
  int code = 0;
};

/// Runs a program and waits for its end. It has no input, its errors are discarded, and it inherits
/// no handler or mask of signals. Safe with any number of threads: of this process, the child
/// receives only its environment.
/// \param command file and arguments \param seconds limit until each next line that counts
/// \param line called with each line that it prints; returns whether it counts
ChildEnd run_child(const std::vector<std::string>& command, double seconds,
                   const std::function<bool(std::string_view)>& line);

}  // namespace enfilade::render::gl
