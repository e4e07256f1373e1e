/// \file  A run of a real program, for tests that kill it.
#pragma once
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace enfilade::tests {

/// Says nothing on the terminal. Killed with this object, if it still runs.
class Process {
 public:
  /// \param words program and arguments \param output where what it prints goes, from its start
  /// \param environment variables that it has beside ours \param errors where its errors go
  explicit Process(std::vector<std::string> words,
                   const std::filesystem::path& output = "/dev/null",
                   const std::map<std::string, std::string>& environment = {},
                   const std::filesystem::path& errors = "/dev/null") {
    std::vector<char*> argv;
    for (std::string& word : words) argv.push_back(word.data());
    argv.push_back(nullptr);
    pid_ = fork();
    if (pid_ != 0) return;
    dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);
    dup2(open(errors.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600), STDERR_FILENO);
    dup2(open(output.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600), STDOUT_FILENO);
    for (const auto& [name, value] : environment) setenv(name.c_str(), value.c_str(), 1);
    execv(argv[0], argv.data());
    _exit(127);
  }
  ~Process() { end(); }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const noexcept { return pid_; }
  /// SIGKILL, unless it has ended; as wait().
  int end() {
    if (!status_ && pid_ > 0) ::kill(pid_, SIGKILL);
    return wait();
  }
  /// Its exit status, or minus the signal that ended it.
  int wait() {
    if (!status_) {
      int status = 0;
      rusage used{};
      wait4(pid_, &status, 0, &used);
      status_ = status;
      const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
      };
      work_ = seconds(used.ru_utime) + seconds(used.ru_stime);
      most_memory_ = static_cast<std::size_t>(used.ru_maxrss) << 10U;
    }
    return WIFEXITED(*status_) ? WEXITSTATUS(*status_) : -WTERMSIG(*status_);
  }
  /// Bytes that were in memory at most; 0 before wait().
  std::size_t most_memory() const noexcept { return most_memory_; }
  /// Seconds of processors' time until now: tells how far it is however busy the machine.
  double work() const {
    clockid_t clock{};
    timespec t{};
    if (status_ || clock_getcpuclockid(pid_, &clock) != 0 || clock_gettime(clock, &t) != 0) {
      return work_;
    }
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
  }
  /// Looks five times a millisecond. False if it ended by itself before that.
  bool killed_when(const std::function<bool()>& moment) {
    while (!moment()) {
      int status = 0;
      if (waitpid(pid_, &status, WNOHANG) == pid_) {
        status_ = status;
        return false;
      }
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
    return end() == -SIGKILL;
  }

 private:
  pid_t pid_ = -1;
  std::optional<int> status_;
  double work_ = 0;
  std::size_t most_memory_ = 0;
};

}  // namespace enfilade::tests
