#include "apps/common/program.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <set>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/core/numbers.h"
#include "enfilade/core/written_lists.h"

namespace enfilade::apps {
namespace {

using Clock = std::chrono::steady_clock;

constexpr const char* kWhereTheDataIs =
    "no data set: give --data DIR or set ENFILADE_DATA to a folder that holds connectivity/ and "
    "r2r/.\n"
    "The 90 graphs are the folder connectivity/ of the repository "
    "peteanderson80/Matterport3DSimulator on GitHub; its tasks/R2R/data/download.sh fetches the "
    "R2R annotations (no licence form is needed for either).\n"
    "To try Enfilade without them: enfilade synth -o DIR makes a small synthetic data set";

class Bar {
 public:
  explicit Bar(const std::string& what) : what_(printable(what)) {}
  ~Bar() { wipe(); }
  Bar(const Bar&) = delete;
  Bar& operator=(const Bar&) = delete;

  void show(std::size_t done, std::size_t total) {
    const Clock::time_point now = Clock::now();
    if (done >= total) {
      wipe();
      return;
    }
    if (now - start_ < std::chrono::seconds(1)) return;  // short work needs no bar
    if (now - drawn_ < std::chrono::milliseconds(100)) return;
    drawn_ = now;
    constexpr std::size_t kWidth = 30;
    const double share = static_cast<double>(done) / static_cast<double>(total);
    const auto full = static_cast<std::size_t>(share * kWidth);
    const double elapsed = std::chrono::duration<double>(now - start_).count();
    const std::string left =
        done == 0 ? "" : fmt::format(", {:.0f} s left", elapsed / share - elapsed);
    fmt::print(stderr, "\r{} [{}{}] {:3.0f} %{}\033[K", what_, std::string(full, '#'),
               std::string(kWidth - full, '.'), 100 * share, left);
    visible_ = true;
  }

 private:
  void wipe() {
    if (visible_) fmt::print(stderr, "\r\033[K");
    visible_ = false;
  }

  std::string what_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point drawn_;
  bool visible_ = false;
};

// \param kind "a whole number"
template <class T>
CLI::Validator number_between(const char* kind, T least, T most) {
  const std::string allowed = most == std::numeric_limits<T>::max()
                                  ? fmt::format("{} from {} on", kind, least)
                                  : fmt::format("{} from {} to {}", kind, least, most);
  return {[=](const std::string& text) {
            const std::optional<T> value = parse_number<T>(text);
            const bool good = value && *value >= least && *value <= most;
            return good ? std::string() : fmt::format("{:?} is not {}", text, allowed);
          },
          ""};
}

// With a null behind them, as exec() and its like take them.
std::vector<char*> pointers_to(std::vector<std::string>& words) {
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  return pointers;
}

int fail(int code, const CLI::App& app, const char* what) {
  say(stderr, "{}: {}\n", app.get_name(), what);
  return code;
}

// CLI11 alone would say "a subcommand is required" of an unknown verb.
void refuse_unknown_verb(const CLI::App& app, int argc, char** argv) {
  if (argc < 2 || app.get_require_subcommand_min() == 0) return;
  const std::string verb = argv[1];
  std::set<std::string> names;
  for (const CLI::App* one : app.get_subcommands({})) {
    if (one->check_name(verb)) return;
    names.insert(one->get_name());
  }
  if (verb.starts_with('-')) return;
  throw UsageError(
      fmt::format("unknown verb {:?}; the verbs are {}", verb, fmt::join(names, ", ")));
}

// For all verbs. An empty name would be taken for a missing option.
void refuse_empty_names(CLI::App& app) {
  const CLI::Validator named(
      [](const std::string& text) {
        return text.empty() ? std::string("the name of a file or folder is empty") : std::string();
      },
      "");
  for (CLI::Option* option : app.get_options()) {
    const std::string type = option->get_type_name();
    if (type.find("FILE") != std::string::npos || type.find("DIR") != std::string::npos) {
      option->check(named);
    }
  }
  for (CLI::App* verb : app.get_subcommands({})) refuse_empty_names(*verb);
}

// What takes all memory is a file or a number of the command line; readers name their file.
constexpr const char* kOutOfMemory =
    "out of memory: an input, or a number of the command line, needs more than there is";

// Callbacks run inside parse(): this is the whole program.
int parse_and_run(CLI::App& app, int argc, char** argv, const int& status) {
  try {
    refuse_unknown_verb(app, argc, argv);
    refuse_empty_names(app);
    app.parse(argc, argv);
    return status;
  } catch (const CLI::Success& help) {
    return app.exit(help);  // prints what --help or --version asked for
  } catch (const CLI::ParseError& error) {
    std::ostringstream text;
    app.exit(error, text, text);
    say(stderr, "{}", text.str());
    return kUsage;
  } catch (const InvalidInput& error) {
    print_diagnostics(error.diagnostics());
    return kInput;
  } catch (const FileError& error) {
    return fail(kInput, app, error.what());
  } catch (const CutShort& error) {
    return fail(kAgain, app, error.what());
  } catch (const Error& error) {  // a name or value from the command line
    return fail(kUsage, app, error.what());
  } catch (const std::filesystem::filesystem_error& error) {  // names the path
    return fail(kInput, app, error.what());
  } catch (const std::bad_alloc&) {
    return fail(kInput, app, kOutOfMemory);
  } catch (const std::length_error&) {  // a list longer than any memory
    return fail(kInput, app, kOutOfMemory);
  } catch (const std::exception& error) {
    return fail(kInternal, app, error.what());
  }
}

}  // namespace

void add_data_option(CLI::App& verb, std::string& data) {
  verb.add_option("--data", data,
                  "Data set: a folder with connectivity/ and r2r/ (default: ENFILADE_DATA)")
      ->type_name("DIR");
}

dataset::Dataset open_data(const std::string& data) {
  if (!data.empty()) return dataset::Dataset(data);
  if (const auto named = dataset::Dataset::from_environment()) return *named;
  throw UsageError(kWhereTheDataIs);
}

CLI::Validator whole_number(std::uint64_t least, std::uint64_t most) {
  return number_between("a whole number", least, most);
}

CLI::Validator finite_number(double least, double most) {
  return number_between("a finite number", least, most);
}

void set_examples(CLI::App& verb, const std::vector<std::string>& lines, const std::string& note) {
  std::string text = "Examples:";
  for (const std::string& line : lines) text += "\n  " + line;
  verb.footer(note.empty() ? text : text + "\n" + note);
}

std::string counted(std::size_t n, const char* what) {
  return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
}

Progress progress_bar(std::string what) {
  if (isatty(STDERR_FILENO) == 0) return {};
  return [bar = std::make_shared<Bar>(std::move(what))](std::size_t done, std::size_t total) {
    bar->show(done, total);
  };
}

Shard parse_shard(const std::string& text) {
  if (text.empty()) return {};
  const std::size_t slash = std::min(text.find('/'), text.size());
  const auto number = parse_number<std::size_t>(std::string_view(text).substr(0, slash));
  const auto count =
      parse_number<std::size_t>(std::string_view(text).substr(std::min(slash + 1, text.size())));
  if (!number || !count || *number < 1 || *number > *count) {
    throw UsageError(
        fmt::format("--shard {:?}: K/N is expected, the K-th of N shares, K from 1 to N", text));
  }
  return {*number - 1, *count};
}

std::filesystem::path shard_file(const std::filesystem::path& file, const Shard& shard) {
  if (shard.count == 1) return file;
  std::filesystem::path own = file;
  own.replace_filename(fmt::format("{}.{}-of-{}{}", file.stem().string(), shard.index + 1,
                                   shard.count, file.extension().string()));
  return own;
}

std::filesystem::path own_program() {
  std::error_code code;
  const auto program = std::filesystem::read_symlink("/proc/self/exe", code);
  return code ? "enfilade" : program;
}

int run_command(std::vector<std::string> words) {
  const std::vector<char*> arguments = pointers_to(words);
  std::array<int, 2> faults{};
  if (pipe2(faults.data(), O_CLOEXEC) != 0) return -errno;
  const pid_t self = getpid();
  const pid_t child = fork();
  if (child == 0) {
    // If this program is killed, the other one must not go on in a folder that the next run uses.
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() == self) execvp(arguments[0], arguments.data());
    const int error = errno;
    [[maybe_unused]] const auto written = write(faults[1], &error, sizeof(error));
    _exit(kInternal);
  }
  int error = child < 0 ? errno : 0;
  close(faults[1]);
  while (child > 0 && read(faults[0], &error, sizeof(error)) < 0 && errno == EINTR) {
  }
  close(faults[0]);
  int status = 0;
  while (child > 0 && waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (error != 0) return -error;
  return WIFEXITED(status) ? WEXITSTATUS(status) : kInternal;
}

int become(const std::string& program, std::vector<std::string> words) {
  std::fflush(stdout);
  execvp(program.c_str(), pointers_to(words).data());
  return errno;
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  return processor_name_in(text);
}

std::string processor_name_in(std::string_view cpuinfo) {
  const auto field = [cpuinfo](std::string_view name) {
    for (std::size_t at = 0; at < cpuinfo.size();) {
      const std::string_view line = cpuinfo.substr(at, cpuinfo.find('\n', at) - at);
      const std::size_t colon = line.find(": ");
      if (line.starts_with(name) && colon != std::string_view::npos) return line.substr(colon + 2);
      at += line.size() + 1;
    }
    return std::string_view();
  };
  if (const std::string_view name = field("model name"); !name.empty()) return std::string(name);
  const std::string_view maker = field("CPU implementer"), part = field("CPU part");
  if (maker.empty() || part.empty()) return "unknown processor";
  // From the MIDR_EL1 pages of Arm's manuals; those that our users' machines have.
  constexpr std::pair<std::string_view, std::string_view> kArm[] = {
      {"0xd07", "Cortex-A57"},  {"0xd08", "Cortex-A72"},  {"0xd0b", "Cortex-A76"},
      {"0xd0c", "Neoverse-N1"}, {"0xd40", "Neoverse-V1"}, {"0xd42", "Cortex-A78AE"},
      {"0xd49", "Neoverse-N2"}, {"0xd4f", "Neoverse-V2"}};
  std::string name = fmt::format("ARM {}/{}", maker, part);
  for (const auto& [number, known] : kArm) {
    if (maker == "0x41" && part == number) name += fmt::format(" ({})", known);
  }
  return name;
}

std::string read_secret(const std::string& file, std::initializer_list<const char*> variables) {
  std::string secret;
  if (!file.empty()) {
    constexpr std::size_t kMostBytes = std::size_t{1} << 16U;
    secret = read_plain_text(file, kMostBytes);
  } else {
    for (const char* name : variables) {
      const char* value = std::getenv(name);
      if (secret.empty() && value != nullptr) secret = value;
    }
  }
  while (secret.ends_with('\n') || secret.ends_with('\r')) secret.pop_back();
  return secret;
}

void write_output(const std::string& path, const std::string& content) {
  if (path != "-") {
    write_file_atomically(path, content);
    return;
  }
  if (std::fwrite(content.data(), 1, content.size(), stdout) != content.size() ||
      std::fflush(stdout) != 0) {
    throw FileError("standard output: cannot write");
  }
}

void print_diagnostics(const std::vector<Diagnostic>& diagnostics) {
  for (const Diagnostic& diagnostic : diagnostics) {
    say(stderr, "{}\n", to_string(diagnostic));
  }
  say(stderr, "{}, {}, {}\n", counted(count(diagnostics, Severity::kError), "error"),
      counted(count(diagnostics, Severity::kWarning), "warning"),
      counted(count(diagnostics, Severity::kNote), "note"));
}

int run_program(CLI::App& app, int argc, char** argv, const int& status) {
  const int code = parse_and_run(app, argc, argv, status);
  if (std::fflush(stdout) != 0) return fail(kInput, app, "standard output: cannot write");
  return code;
}

}  // namespace enfilade::apps
