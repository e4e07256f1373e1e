#include "enfilade/core/child_process.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <thread>

namespace enfilade {
namespace {

/// Settings of posix_spawn(), freed with this object.
class SpawnSettings {
 public:
  /// \param output  where the other process's standard output goes
  SpawnSettings(int output, const ChildProcess::Settings& settings) {
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, output, STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    if (settings.reads_errors) {
      posix_spawn_file_actions_adddup2(&files, output, STDERR_FILENO);
    } else {
      posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    }
    sigset_t all, none;
    sigfillset(&all);
    sigemptyset(&none);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setpgroup(&attributes, 0);
    const int group = settings.own_group ? POSIX_SPAWN_SETPGROUP : 0;
    posix_spawnattr_setflags(
        &attributes, static_cast<short>(POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK | group));
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  posix_spawn_file_actions_t files{};
  posix_spawnattr_t attributes{};
};

// POSIX lets posix_spawn() succeed where the program cannot be executed: the new process then exits
// with 127. So it is in qemu-user, where the two share no memory for the error.
ChildEnd unless_not_started(const ChildEnd& end) {
  constexpr int kNotExecuted = 127;
  if (end.how != ChildEnd::How::kExited || end.code != kNotExecuted) return end;
  return {ChildEnd::How::kNotStarted, ENOENT};
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& command, Settings settings)
    : own_group_(settings.own_group) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) {
    error_ = errno;
    return;
  }
  std::vector<std::string> words = command;
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const SpawnSettings spawn(ends[1], settings);
  error_ = posix_spawnp(&child_, arguments[0], &spawn.files, &spawn.attributes, arguments.data(),
                        environ);
  close(ends[1]);
  output_ = ends[0];
}

ChildProcess::~ChildProcess() {
  if (output_ >= 0) close(output_);
}

std::optional<bool> ChildProcess::read_some(std::string& text, Clock::time_point until) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    pollfd wanted{output_, POLLIN, 0};
    const int ready =
        poll(&wanted, 1, static_cast<int>(std::clamp<std::int64_t>(left, 0, 1'000'000)));
    if (ready == 0) return std::nullopt;
    if (ready < 0 && errno == EINTR) continue;
    std::array<char, 4096> buffer{};
    const ssize_t count = read(output_, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    text.append(buffer.data(), static_cast<std::size_t>(count));
    printed_ = true;
    return true;
  }
}

// No value if it still runs then. Not waitpid() alone: a process whose driver hangs in the kernel
// does not even end when it is killed.
std::optional<ChildEnd> ChildProcess::end_within(Clock::time_point until) const {
  constexpr std::chrono::milliseconds kPause(2);
  for (;;) {
    int status = 0;
    const pid_t ended = waitpid(child_, &status, WNOHANG);
    if (ended == child_ && WIFSIGNALED(status))
      return ChildEnd{ChildEnd::How::kKilled, WTERMSIG(status)};
    if (ended == child_) return ChildEnd{ChildEnd::How::kExited, WEXITSTATUS(status)};
    if (ended < 0 && errno != EINTR) return ChildEnd{ChildEnd::How::kExited, -1};
    if (Clock::now() >= until) return std::nullopt;
    std::this_thread::sleep_for(kPause);
  }
}

ChildEnd ChildProcess::end_by(Clock::time_point until) {
  close(output_);  // a program that still prints ends by it
  output_ = -1;
  if (const auto end = end_within(until)) return printed_ ? *end : unless_not_started(*end);
  kill(own_group_ ? -child_ : child_, SIGKILL);
  end_within(Clock::now() + std::chrono::seconds(2));
  return {ChildEnd::How::kSilent, 0};
}

}  // namespace enfilade
