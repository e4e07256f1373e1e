/// \file  Files and child processes for tests of memory that processes share.
#pragma once
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstddef>
#include <filesystem>
#include <string>
#include <system_error>

namespace enfilade::tests {

/// A name in /dev/shm that no other test uses; the file is removed with this object.
class SharedName {
 public:
  explicit SharedName(const std::string& name)
      : path_("/dev/shm/enfilade-test-" + name + "-" + std::to_string(getpid())),
        owner_(getpid()) {}
  ~SharedName() {
    std::error_code ignored;
    if (getpid() == owner_) std::filesystem::remove(path_, ignored);
  }
  SharedName(const SharedName&) = delete;
  SharedName& operator=(const SharedName&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
  pid_t owner_;
};

/// Runs `work` in a forked child, which ends with what it returns.
template <class Work>
pid_t in_child(const Work& work) {
  const pid_t child = fork();
  if (child == 0) _exit(work());
  return child;
}

/// The child's exit status, or 128 + the signal that ended it.
inline int wait_for(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

/// Whether a lock is freed with the process that holds it (robust futexes). qemu-user cannot: the
/// kernel that sees the process end knows nothing of the locks of the program that is emulated.
inline bool frees_locks_of_killed() {
  void* head = nullptr;
  std::size_t size = 0;
  return syscall(SYS_get_robust_list, 0, &head, &size) == 0;
}
inline constexpr const char* kKeepsLocksOfKilled =
    "here a killed process keeps its locks (no robust futexes: qemu-user)";

}  // namespace enfilade::tests
