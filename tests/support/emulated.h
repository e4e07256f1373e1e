/// \file  What tests in qemu-user cannot see.
#pragma once
#include <unistd.h>

#include <filesystem>
#include <string>
#include <system_error>

namespace enfilade::tests {

/// Whether qemu-user runs this program: it shows the program's file as /proc/self/exe, and its own
/// as that of the first thread. Then memory is the emulator's, and the program cannot start itself,
/// unless the kernel knows how (binfmt_misc).
inline bool is_emulated() {
  const std::filesystem::path self("/proc/self");
  std::error_code first, second;
  return std::filesystem::read_symlink(self / "exe", first) !=
         std::filesystem::read_symlink(self / "task" / std::to_string(getpid()) / "exe", second);
}

}  // namespace enfilade::tests
