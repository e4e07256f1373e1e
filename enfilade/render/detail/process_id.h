/// \file  Identity of a process, so that others can check whether it still runs.
#pragma once
#include <cstdint>

namespace enfilade::render::detail {

/// A process of this machine. Numbers are used again, but not by a process that started at the same
/// time; and each PID namespace (container) has its own.
struct ProcessId {
  std::int32_t number = 0;       ///< 0: none
  std::uint64_t start = 0;       ///< clock ticks since the machine's start
  std::uint64_t name_space = 0;  ///< inode of its PID namespace
  friend bool operator==(const ProcessId&, const ProcessId&) = default;
};

/// The calling process. \throws FileError if /proc cannot be read
ProcessId this_process();

/// False if the process has certainly ended; true also where that cannot be found out, as for a
/// process of another container. A zombie has ended. Any thread.
/// \param here the calling process
bool may_run(const ProcessId& process, const ProcessId& here) noexcept;

}  // namespace enfilade::render::detail
