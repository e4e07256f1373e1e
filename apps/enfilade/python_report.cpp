#include "apps/enfilade/python_report.h"

#include <fmt/format.h>
#include <unistd.h>
#include <algorithm>
#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>
#include <vector>

#include "apps/common/program.h"
#include "enfilade/core/child_process.h"
#include "enfilade/core/names.h"

namespace enfilade::apps {
namespace {

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

constexpr ChildProcess::Settings kWithErrors{.reads_errors = true, .own_group = true};

// Runs it to its end, or for so many seconds. `text`: the first of what it prints.
ChildEnd run_for(const std::vector<std::string>& words, double seconds, std::string& text) {
  using Clock = ChildProcess::Clock;
  ChildProcess child(words, kWithErrors);
  if (child.start_error() != 0) return {ChildEnd::How::kNotStarted, child.start_error()};
  const auto until =
      Clock::now() + std::chrono::ceil<Clock::duration>(std::chrono::duration<double>(seconds));
  std::string more;
  while (Clock::now() < until && child.read_some(more, until).value_or(false)) {
    if (text.size() < kMostText) text += more;
    more.clear();
  }
  if (text.size() >= kMostText) text.resize(text.rfind('\n') + 1);  // no part of a line
  return child.end_by(until);
}

std::string words_of(const ChildEnd& end, double seconds) {
  switch (end.how) {
    case ChildEnd::How::kSilent:
      return fmt::format("no answer for {:g} s", seconds);
    case ChildEnd::How::kKilled:
      return fmt::format("it crashed (signal {})", end.code);
    case ChildEnd::How::kNotStarted:
      return std::strerror(end.code);
    case ChildEnd::How::kExited:
      break;
  }
  return fmt::format("it ended with exit status {}", end.code);
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
  const ChildEnd end = run_for({program, "-c", kCode}, seconds, text);
  const Told told = told_in(text);
  const std::string why =
      words_of(end, seconds) + (told.last_line.empty() ? "" : ": " + told.last_line);
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
