/// \file  How much memory this process may still take.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>

namespace enfilade {

/// Bytes that are free, or can be made so without swapping: the machine's (MemAvailable), or those
/// left to the process's cgroup (version 2; what a container has), if these are fewer. 0 if the
/// system does not say.
/// \param proc, cgroup where the system says it; another folder in tests
std::uint64_t available_memory(const std::filesystem::path& proc = "/proc",
                               const std::filesystem::path& cgroup = "/sys/fs/cgroup");

}  // namespace enfilade
