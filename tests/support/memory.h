/// \file  How much memory this process takes.
#pragma once
#include <cstddef>
#include <fstream>
#include <string>
#include <string_view>

namespace enfilade::tests {

/// Bytes of this process's memory: "VmRSS:" now, "VmHWM:" the most since forget_peak(). 0 where the
/// system does not say.
inline std::size_t memory(std::string_view what) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(what)) return std::stoul(line.substr(what.size())) << 10U;
  }
  return 0;
}

/// False where the system does not allow it: the peak is the whole process's then.
inline bool forget_peak() {
  std::ofstream file("/proc/self/clear_refs");
  file << "5" << std::flush;
  return file.good();
}

}  // namespace enfilade::tests
