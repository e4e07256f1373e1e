/// \file  How much of a mapped file is in this process's memory.
#pragma once
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>

namespace enfilade::tests {

/// Bytes; 0 for a file that is not mapped.
inline std::uint64_t resident_bytes_of(const std::filesystem::path& file) {
  std::ifstream maps("/proc/self/smaps");
  std::uint64_t kilobytes = 0;
  bool of_file = false;
  for (std::string line; std::getline(maps, line);) {
    // "55d0-55d2 r--p 0000 fe:00 24 FILE" begins a mapping, "Rss:   8 kB" and others tell of it.
    if (line.find('-') < line.find(':')) of_file = line.ends_with(file.string());
    if (of_file && line.starts_with("Rss:")) kilobytes += std::stoul(line.substr(4));
  }
  return kilobytes * 1024;
}

}  // namespace enfilade::tests
