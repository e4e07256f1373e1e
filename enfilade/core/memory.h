/// \file  How much memory this process may still take.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace enfilade {

/// Bytes that are free, or can be freed without swapping. The smaller of the machine's
/// (MemAvailable) and those left to the process's cgroup (version 2, as in a container). 0 if the
/// system does not report it.
/// \param proc, cgroup the system's folders; other folders in tests
std::uint64_t available_memory(const std::filesystem::path& proc = "/proc",
                               const std::filesystem::path& cgroup = "/sys/fs/cgroup");

}  // namespace enfilade
