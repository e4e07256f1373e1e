#include "enfilade/render/gl/trial.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <map>
#include <mutex>
#include <span>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::render {
namespace gl {
namespace {

// --- its words -----------------------------------------------------------------------------------

constexpr std::string_view kPrefix = "enfilade-gl";

constexpr const char* kSeconds = "ENFILADE_GL_SECONDS";

// Longer than any driver was seen to take: some seconds, where each of eight cards wakes up.
double seconds_of_a_trial() {
  constexpr double kDefault = 30;
  const char* value = std::getenv(kSeconds);
  if (value == nullptr || *value == 0) return kDefault;
  const std::string_view text(value);
  double seconds = 0;
  const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), seconds);
  if (code != std::errc() || end != text.data() + text.size() ||
      !(seconds >= 0 && seconds <= 1e6)) {
    throw ArgumentError(fmt::format(
        "{}: {:?}, not a number of seconds from 0 to 1000000 (0: drivers are not tried first)",
        kSeconds, text));
  }
  return seconds;
}

std::string signal_name(int signal) {
  using Name = std::pair<int, const char*>;
  constexpr std::array kNames{Name{SIGSEGV, "SIGSEGV"}, Name{SIGBUS, "SIGBUS"},
                              Name{SIGILL, "SIGILL"},   Name{SIGFPE, "SIGFPE"},
                              Name{SIGABRT, "SIGABRT"}, Name{SIGKILL, "SIGKILL"},
                              Name{SIGTRAP, "SIGTRAP"}, Name{SIGSYS, "SIGSYS"}};
  for (const auto& [number, name] : kNames) {
    if (number == signal) return name;
  }
  return fmt::format("signal {}", signal);
}

/// What one process told before it ended.
struct Told {
  std::vector<GlDevice> devices;
  std::string trying, drivers, place;  // of the latest trial; place: the file that crashed
  bool finished = false;
  std::string error;
  bool is_argument_error = false;

  bool take(std::string_view line);  ///< false for other lines
};

bool Told::take(std::string_view line) {
  const std::vector<std::string> words = words_of(line);
  const auto is = [&](std::string_view name, std::size_t count) {
    return words.size() == count + 1 && words[0] == name;
  };
  if (is(kTrying, 2)) {
    trying = words[1];
    drivers = words[2];
  } else if (is(kPlace, 1)) {
    place = words[1];
  } else if (is(kDeviceLine, 7)) {
    devices.push_back(
        {words[1], words[2], words[3] == kYes, words[4], words[5], words[6], words[7] == kYes});
  } else if (is(kRefused, 2)) {
    is_argument_error = words[1] == kYes;
    error = words[2];
    finished = true;
  } else if (is(kFinished, 0)) {
    finished = true;
  }
  return !words.empty();
}

std::string fault_of(const Told& told, const ChildEnd& end, double seconds) {
  using How = ChildEnd::How;
  std::string fault =
      end.how == How::kSilent ? fmt::format("hung (no answer for {:g} s)", seconds)
      : end.how == How::kKilled
          ? fmt::format("crashed ({}{}{})", signal_name(end.code), told.place.empty() ? "" : " in ",
                        told.place)
          : fmt::format("ended the process that tried it (exit status {})", end.code);
  if (!told.drivers.empty()) fault += fmt::format("; drivers that were loaded: {}", told.drivers);
  return fault;
}

class Trials {
 public:
  static Trials& of_this_process() {
    static Trials trials;
    return trials;
  }

  void set(std::vector<std::string> command) {
    const std::lock_guard lock(mutex_);
    command_ = std::move(command);
    verdicts_.clear();
  }

  std::optional<std::vector<GlDevice>> devices() {
    const std::lock_guard lock(mutex_);
    std::optional<Told> told = try_all({std::string(kList), ""});
    if (!told) return std::nullopt;
    if (told->devices.empty() && !told->error.empty()) {
      GlDevice all;
      all.name = "all";
      all.error = told->error;
      all.broken = true;
      return std::vector{all};
    }
    return std::move(told->devices);
  }

  std::optional<std::string> way(const std::string& device) {
    const std::lock_guard lock(mutex_);
    auto known = verdicts_.find(device);
    if (known == verdicts_.end()) {
      std::optional<Told> told = try_all({std::string(kFind), device});
      if (!told) return std::nullopt;
      known = verdicts_.emplace(device, std::move(*told)).first;
    }
    const Told& told = known->second;
    if (told.error.empty()) return told.trying;
    if (told.is_argument_error) throw ArgumentError(told.error);
    throw Error(told.error);
  }

 private:
  // What the first process tells that gets to its end. Each knows what the ones before it died of.
  std::optional<Told> try_all(const std::vector<std::string>& words) const {
    const double seconds = seconds_of_a_trial();
    if (command_.empty() || seconds == 0) return std::nullopt;
    std::vector<std::string> command = command_;
    command.insert(command.end(), words.begin(), words.end());
    std::map<std::string, std::string> faults;
    for (;;) {
      Told told;
      const ChildEnd end =
          run_child(command, seconds, [&](std::string_view line) { return told.take(line); });
      if (end.how == ChildEnd::How::kNotStarted) return std::nullopt;
      if (told.finished) {
        if (!told.error.empty() && !faults.empty())
          told.error += fmt::format("\n{}", kBrokenAdvice);
        return told;
      }
      const std::string fault = "the OpenGL driver " + fault_of(told, end, seconds);
      if (told.trying.empty() || !faults.emplace(told.trying, fault).second) {
        told.error = fmt::format("{} while the EGL devices were listed\n{}", fault, kBrokenAdvice);
        return told;
      }
      command.insert(command.end(), {told.trying, fault});
    }
  }

  std::mutex mutex_;
  std::vector<std::string> command_;
  std::map<std::string, Told> verdicts_;  // by device
};

}  // namespace

ChildEnd run_child(const std::vector<std::string>& command, double seconds,
                   const std::function<bool(std::string_view)>& line) {
  using Clock = ChildProcess::Clock;
  ChildProcess child(command);
  if (child.start_error() != 0) return {ChildEnd::How::kNotStarted, child.start_error()};
  const auto limit =
      std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  Clock::time_point until = Clock::now() + limit;
  std::string text;
  for (;;) {
    const auto more = child.read_some(text, until);
    for (std::size_t end = 0; (end = text.find('\n')) != std::string::npos;) {
      if (line(std::string_view(text).substr(0, end))) until = Clock::now() + limit;
      text.erase(0, end + 1);
    }
    if (!more || !*more || Clock::now() >= until) break;
  }
  return child.end_by(until);
}

std::string line_of(const std::vector<std::string_view>& words) {
  std::string line = "\n";  // what a driver printed need not have ended its line
  line += kPrefix;
  for (const std::string_view word : words) {
    line += '\t';
    for (const char c : word) {
      if (c == '\\' || c == '\n' || c == '\t') line += '\\';
      line += c == '\n' ? 'n' : c == '\t' ? 't' : c;
    }
  }
  return line + '\n';
}

std::vector<std::string> words_of(std::string_view line) {
  if (!line.starts_with(kPrefix)) return {};
  line.remove_prefix(kPrefix.size());
  std::vector<std::string> words;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '\t') {
      words.emplace_back();
    } else if (words.empty()) {
      return {};
    } else if (line[i] != '\\' || i + 1 == line.size()) {
      words.back() += line[i];
    } else {
      const char c = line[++i];
      words.back() += c == 'n' ? '\n' : c == 't' ? '\t' : c;
    }
  }
  return words;
}

std::optional<std::string> tried_way(const std::string& device) {
  return Trials::of_this_process().way(device);
}

std::optional<std::vector<GlDevice>> tried_devices() { return Trials::of_this_process().devices(); }

}  // namespace gl

void set_gl_trial(std::vector<std::string> command) {
  gl::Trials::of_this_process().set(std::move(command));
}

}  // namespace enfilade::render
