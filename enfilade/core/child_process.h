/// \file  A program of its own process that may crash or hang: started, read and ended.
#pragma once
#include <chrono>
#include <optional>
#include <string>
#include <vector>

namespace enfilade {

/// How such a program ended.
struct ChildEnd {
  /// What was seen of its end.
  enum class How {
    kExited,      ///< by itself; code: its exit status, -1 if already collected
    kKilled,      ///< code: the signal
    kSilent,      ///< it printed nothing for too long, and was killed
    kNotStarted,  ///< code: errno; ENOENT where the system does not say
  };
  How how = How::kNotStarted;
  int code = 0;
};

/// Starts a program without input. It inherits no handler or mask of signals, and receives this
/// process's environment and nothing else, whatever other threads do. One thread at a time.
/// Destroyed, it closes the pipe and leaves the program: call end_by() first.
class ChildProcess {
 public:
  /// The clock of its limits.
  using Clock = std::chrono::steady_clock;
  /// What it shares with this process.
  struct Settings {
    bool reads_errors = false;  ///< its errors are read as its output; else they are discarded
    bool own_group = false;     ///< what it starts dies with it; Ctrl-C does not reach it
  };

  /// \param command  a path, or a name on PATH, and arguments
  ChildProcess(const std::vector<std::string>& command, Settings settings);
  explicit ChildProcess(const std::vector<std::string>& command)
      : ChildProcess(command, Settings()) {}
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  /// errno; 0: it was started.
  int start_error() const noexcept { return error_; }
  /// Appends what it prints next. False where nothing more comes; no value if nothing came in time.
  /// \pre start_error() is 0, here and below
  std::optional<bool> read_some(std::string& text, Clock::time_point until);
  /// Waits for its end. If it still runs then, it is killed: kSilent.
  ChildEnd end_by(Clock::time_point until);

 private:
  std::optional<ChildEnd> end_within(Clock::time_point until) const;

  int child_ = 0;  // its process id
  int output_ = -1;
  int error_ = 0;
  bool own_group_ = false;
  bool printed_ = false;
};

}  // namespace enfilade
