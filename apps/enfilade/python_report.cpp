#include "apps/enfilade/python_report.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/common/program.h"
#include "enfilade/core/names.h"

namespace enfilade::apps {
namespace {

using Clock = std::chrono::steady_clock;
using Module = PythonReport::Module;

// In front of each line that is an answer: a module may print when it is imported.
constexpr std::string_view kAnswer = "enfilade-doctor ";
constexpr std::size_t kMostText = std::size_t{1} << 20U;  // of what it prints, in bytes

// Says where the module is before it is imported, as that may crash. Only the drop-in has _missing.
constexpr const char* kCode = R"(
import importlib.util, json, os, sys
def tell(**what):
    what = {k: os.fsencode(str(v)).decode("utf-8", "replace") for k, v in what.items()}
    sys.stdout.write("\nenfilade-doctor " + json.dumps(what) + "\n")
    sys.stdout.flush()
tell(version=".".join(map(str, sys.version_info[:3])))
try:
    spec = importlib.util.find_spec("habitat_sim")
    if spec is not None:
        tell(path=spec.origin or list(spec.submodule_search_locations or ["?"])[0])
        import habitat_sim
        ours = importlib.util.find_spec("habitat_sim._missing") is not None
        tell(module="ours" if ours else "habitat", module_version=getattr(habitat_sim, "__version__", "?"))
    else:
        tell(module="none")
except BaseException as e:
    tell(fault="%s: %s" % (type(e).__name__, e))
)";

/// How a process ended.
struct Ending {
  bool in_time = true;
  int status = 0;  // as of waitpid()
};

// Its standard output and errors go to `output`; it has a group of its own, which dies with it.
int spawn(pid_t& child, std::vector<std::string> words, int output) {
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t files;
  posix_spawn_file_actions_init(&files);
  posix_spawn_file_actions_addopen(&files, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_adddup2(&files, output, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&files, output, STDERR_FILENO);
  posix_spawnattr_t attributes;
  posix_spawnattr_init(&attributes);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  const int error =
      posix_spawnp(&child, arguments[0], &files, &attributes, arguments.data(), environ);
  posix_spawnattr_destroy(&attributes);
  posix_spawn_file_actions_destroy(&files);
  return error;
}

// All that comes until the end, or until then. False if it went on.
bool read_all(int from, std::string& text, Clock::time_point until) {
  for (;;) {
    const auto left = std::chrono::ceil<std::chrono::milliseconds>(until - Clock::now()).count();
    pollfd wanted{from, POLLIN, 0};
    const int ready =
        poll(&wanted, 1, static_cast<int>(std::clamp<std::int64_t>(left, 0, 1'000'000)));
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    std::array<char, 4096> buffer{};
    const ssize_t count = read(from, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return true;
    if (text.size() < kMostText) text.append(buffer.data(), static_cast<std::size_t>(count));
  }
}

// Runs it to its end, or for so many seconds. \returns errno: it did not start
int run_for(const std::vector<std::string>& words, double seconds, std::string& text,
            Ending& ending) {
  std::array<int, 2> pipes{};
  if (pipe2(pipes.data(), O_CLOEXEC) != 0) return errno;
  pid_t child = 0;
  const int error = spawn(child, words, pipes[1]);
  close(pipes[1]);
  if (error == 0) {
    const auto until =
        Clock::now() + std::chrono::ceil<Clock::duration>(std::chrono::duration<double>(seconds));
    ending.in_time = read_all(pipes[0], text, until);
    if (!ending.in_time) kill(-child, SIGKILL);
    while (waitpid(child, &ending.status, 0) < 0 && errno == EINTR) {
    }
  }
  close(pipes[0]);
  return error;
}

std::string words_of(const Ending& ending, double seconds) {
  if (!ending.in_time) return fmt::format("no answer for {:g} s", seconds);
  if (WIFSIGNALED(ending.status)) {
    return fmt::format("it crashed (signal {})", WTERMSIG(ending.status));
  }
  return fmt::format("it ended with exit status {}", WEXITSTATUS(ending.status));
}

/// What it told, and the last line that is no answer.
struct Told {
  nlohmann::json answers = nlohmann::json::object();
  std::string last_line;

  bool has(const char* key) const { return answers.contains(key); }
  std::string text(const char* key) const {
    return has(key) && answers[key].is_string() ? answers[key].get<std::string>() : "";
  }
};

Told told_in(std::string_view text) {
  Told told;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.starts_with(kAnswer)) {
      const auto answer = nlohmann::json::parse(line.substr(kAnswer.size()), nullptr, false);
      if (answer.is_object()) told.answers.update(answer);
    } else if (line.find_first_not_of(" \t\r") != std::string_view::npos) {
      told.last_line = printable(line.substr(0, 200));
    }
  }
  return told;
}

}  // namespace

std::string python_of_this_machine() {
  const std::string beside = own_program().parent_path() / "python3";
  return access(beside.c_str(), X_OK) == 0 ? beside : "python3";
}

PythonReport report_of_python(const std::string& program, double seconds) {
  PythonReport report;
  report.program = program;
  std::string text;
  Ending ending;
  const int error = run_for({program, "-c", kCode}, seconds, text, ending);
  if (error != 0) {
    report.error = std::strerror(error);
    return report;
  }
  const Told told = told_in(text);
  const std::string why =
      words_of(ending, seconds) + (told.last_line.empty() ? "" : ": " + told.last_line);
  report.version = told.text("version");
  if (report.version.empty()) {
    report.error = why;
    return report;
  }
  report.path = told.text("path");
  report.module_version = told.text("module_version");
  const std::string module = told.text("module");
  if (module == "none") return report;
  report.module = module == "ours"      ? Module::kOurs
                  : module == "habitat" ? Module::kHabitats
                                        : Module::kBroken;
  if (report.module == Module::kBroken) {
    report.fault = told.has("fault") ? printable(told.text("fault")) : why;
  }
  return report;
}

}  // namespace enfilade::apps
