#include "enfilade/render/gl/child.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <optional>
#include <thread>

namespace enfilade::render::gl {
namespace {

using Clock = std::chrono::steady_clock;

/// Settings of posix_spawn(), freed with this object.
class SpawnSettings {
 public:
  /// \param output  where the other process's standard output goes
  explicit SpawnSettings(int output) {
    posix_spawn_file_actions_init(&files);
    posix_spawn_file_actions_adddup2(&files, output, STDOUT_FILENO);
    posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&files, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
    sigset_t all, none;
    sigfillset(&all);
    sigemptyset(&none);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSIGMASK);
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

int spawn(pid_t& child, const std::vector<std::string>& command, int output) {
  std::vector<std::string> words = command;
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  const SpawnSettings settings(output);
  return posix_spawn(&child, arguments[0], &settings.files, &settings.attributes, arguments.data(),
                     environ);
}

// False where nothing more comes; no value if nothing came in time.
std::optional<bool> read_some(int from, std::string& text, Clock::time_point until) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    pollfd wanted{from, POLLIN, 0};
    const int ready =
        poll(&wanted, 1, static_cast<int>(std::clamp<std::int64_t>(left, 0, 1'000'000)));
    if (ready == 0) return std::nullopt;
    if (ready < 0 && errno == EINTR) continue;
    std::array<char, 4096> buffer{};
    const ssize_t count = read(from, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    text.append(buffer.data(), static_cast<std::size_t>(count));
    return true;
  }
}

// No value if it still runs then. Not waitpid() alone: a process whose driver hangs in the kernel
// does not even end when it is killed.
std::optional<ChildEnd> end_of(pid_t child, Clock::time_point until) {
  constexpr std::chrono::milliseconds kPause(2);
  for (;;) {
    int status = 0;
    const pid_t ended = waitpid(child, &status, WNOHANG);
    if (ended == child && WIFSIGNALED(status))
      return ChildEnd{ChildEnd::How::kKilled, WTERMSIG(status)};
    if (ended == child) return ChildEnd{ChildEnd::How::kExited, WEXITSTATUS(status)};
    if (ended < 0 && errno != EINTR) return ChildEnd{ChildEnd::How::kExited, -1};
    if (Clock::now() >= until) return std::nullopt;
    std::this_thread::sleep_for(kPause);
  }
}

// POSIX lets posix_spawn() succeed where the program cannot be executed: the new process then exits
// with 127. So it is in qemu-user, where the two share no memory for the error.
ChildEnd unless_not_started(const ChildEnd& end) {
  constexpr int kNotExecuted = 127;
  if (end.how != ChildEnd::How::kExited || end.code != kNotExecuted) return end;
  return {ChildEnd::How::kNotStarted, ENOENT};
}

}  // namespace

ChildEnd run_child(const std::vector<std::string>& command, double seconds,
                   const std::function<bool(std::string_view)>& line) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) return {ChildEnd::How::kNotStarted, errno};
  pid_t child = 0;
  const int error = spawn(child, command, ends[1]);
  close(ends[1]);
  if (error != 0) {
    close(ends[0]);
    return {ChildEnd::How::kNotStarted, error};
  }
  const auto limit =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  Clock::time_point until = Clock::now() + limit;
  std::string text;
  bool printed = false;
  for (;;) {
    const auto more = read_some(ends[0], text, until);
    printed = printed || !text.empty();
    for (std::size_t end = 0; (end = text.find('\n')) != std::string::npos;) {
      if (line(std::string_view(text).substr(0, end))) until = Clock::now() + limit;
      text.erase(0, end + 1);
    }
    if (!more || !*more || Clock::now() >= until) break;
  }
  close(ends[0]);
  if (const auto end = end_of(child, until)) return printed ? *end : unless_not_started(*end);
  kill(child, SIGKILL);
  end_of(child, Clock::now() + std::chrono::seconds(2));
  return {ChildEnd::How::kSilent, 0};
}

}  // namespace enfilade::render::gl
