#include "enfilade/core/memory.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>
#include <string>

namespace enfilade {
namespace {

std::optional<std::uint64_t> number_in(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::uint64_t value = 0;
  if (in >> value) return value;
  return std::nullopt;  // also for "max", no limit
}

// The value of a line "NAME: 123 kB", in bytes.
std::optional<std::uint64_t> kib_in(const std::filesystem::path& file, const std::string& name) {
  std::ifstream in(file);
  std::string word;
  while (in >> word) {
    std::uint64_t value = 0;
    if (word == name && in >> value) return value * 1024;
    in.ignore(std::numeric_limits<std::streamsize>::max(), '\n');
  }
  return std::nullopt;
}

// The folder of this process's cgroup: the line "0::/its/path" names it.
std::filesystem::path own_cgroup(const std::filesystem::path& proc,
                                 const std::filesystem::path& root) {
  std::ifstream in(proc / "self/cgroup");
  std::string line;
  while (std::getline(in, line)) {
    if (line.starts_with("0::/")) return root / line.substr(4);
  }
  return root;
}

}  // namespace

std::uint64_t available_memory(const std::filesystem::path& proc,
                               const std::filesystem::path& cgroup) {
  std::uint64_t available = kib_in(proc / "meminfo", "MemAvailable:").value_or(0);
  // Inside a container the process's cgroup is often the root of what it sees.
  for (const auto& folder : {own_cgroup(proc, cgroup), cgroup}) {
    const auto limit = number_in(folder / "memory.max");
    const auto used = number_in(folder / "memory.current");
    if (!limit || !used) continue;
    const std::uint64_t left = *limit - std::min(*limit, *used);
    available = available == 0 ? left : std::min(available, left);
  }
  return available;
}

}  // namespace enfilade
