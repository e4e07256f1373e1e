/// \file  Shared by all programs of Enfilade: options, exit codes, error messages, progress.
#pragma once
#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/names.h"
#include "enfilade/core/progress.h"
#include "enfilade/dataset/dataset.h"

namespace enfilade::apps {

/// Exit codes, the same for all programs and verbs.
enum ExitCode : int {
  kSuccess = 0,
  kFaultsFound = 1,  ///< it ran, and what it checked has faults (refused results, mismatches)
  kUsage = 2,        ///< the command line cannot be understood or is contradictory
  kInput = 3,        ///< a file or folder is missing, unreadable, broken, or cannot be written
  kInternal = 4,     ///< Enfilade itself failed; please report it
  kAgain = 75,       ///< stopped by another process's end; retry unchanged (EX_TEMPFAIL)
};

/// Thrown by verbs for a command line that CLI11 accepts but that is contradictory. Exit code
/// kUsage.
class UsageError : public Error {
 public:
  using Error::Error;
};

/// Adds `--data DIR` (default: the environment variable ENFILADE_DATA) to a verb.
void add_data_option(CLI::App& verb, std::string& data);
/// The data set of that option.
/// \throws UsageError with sources of the data if `data` is empty and ENFILADE_DATA is unset
/// \throws FileError if it does not name a folder
dataset::Dataset open_data(const std::string& data);

/// Refuses values that CLI11 alone would accept for an unsigned type: "-5" as 2^64 - 5.
CLI::Validator whole_number(std::uint64_t least = 0,
                            std::uint64_t most = std::numeric_limits<std::uint64_t>::max());
/// Refuses NaN, which CLI11's own ranges let pass, infinities and numbers outside.
CLI::Validator finite_number(double least = 0, double most = std::numeric_limits<double>::max());

/// An option whose value is a whole number, at least `least`; --help shows the default, the present
/// `value`.
template <class T>
CLI::Option* add_whole_number(CLI::App& verb, const std::string& name, T& value,
                              const std::string& help, std::uint64_t least = 1) {
  return verb.add_option(name, value, help)->check(whole_number(least))->capture_default_str();
}
/// Adds `--threads N`.
inline void add_threads_option(CLI::App& verb, int& threads,
                               const std::string& help = "0: all cores") {
  verb.add_option("--threads", threads, help)->check(whole_number(0, 1024))->capture_default_str();
}

/// An option `name TYPE` without a default to show.
template <class T>
CLI::Option* add_value(CLI::App& verb, const std::string& name, T& value, const std::string& type,
                       const std::string& help) {
  return verb.add_option(name, value, help)->type_name(type);
}
/// An option `name TYPE`; --help shows the default, which is what `value` is now. `type` may be
/// empty: CLI11's own name of T.
template <class T>
CLI::Option* add_setting(CLI::App& verb, const std::string& name, T& value, const std::string& type,
                         const std::string& help, const CLI::Validator& check = {}) {
  CLI::Option* option = verb.add_option(name, value, help)->check(check)->capture_default_str();
  return type.empty() ? option : option->type_name(type);
}

/// An option whose value is a number of metres, at least 0.
inline void add_metres_option(CLI::App& verb, const std::string& name, double& value,
                              const std::string& help) {
  add_setting(verb, name, value, "M", help, finite_number());
}

/// "Examples:" below a verb's --help; each line a command. \param note  a text below them
void set_examples(CLI::App& verb, const std::vector<std::string>& lines,
                  const std::string& note = {});

/// Prints to a terminal. Names of files and texts of data in it cannot control the terminal:
/// printable() of core/names.h.
template <class... T>
void say(std::FILE* stream, fmt::format_string<T...> format, T&&... values) {
  fmt::print(stream, "{}", printable(fmt::format(format, std::forward<T>(values)...)));
}
/// The same, to stdout.
template <class... T>
void say(fmt::format_string<T...> format, T&&... values) {
  say(stdout, format, std::forward<T>(values)...);
}

/// "1 panorama", "2 panoramas".
std::string counted(std::size_t n, const char* what);

/// Seconds since it was made.
class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// A progress bar on stderr, `what` before it, with the time left. It appears only if stderr is a
/// terminal, after a second. It is drawn at most ten times a second, and wiped at the end.
Progress progress_bar(std::string what);

/// "3/16", the third of sixteen shares; empty: all of it. \throws UsageError
Shard parse_shard(const std::string& text);
/// Output file of one shard: "features.safetensors" -> "features.3-of-16.safetensors".
std::filesystem::path shard_file(const std::filesystem::path& file, const Shard& shard);

/// This program's own file; "enfilade" if the system does not report it.
std::filesystem::path own_program();

/// Runs a program of PATH with its arguments, to its end. It ends with this one, if that is killed.
/// \returns its exit code; kInternal: by a signal; -errno: it did not start
int run_command(std::vector<std::string> words);
/// Becomes a program of PATH; `words` are its name and arguments.
/// \returns errno: it cannot be started
int become(const std::string& program, std::vector<std::string> words);

/// The system's name of the first processor; "unknown processor" without a name.
std::string processor_name();
/// The same from the text of /proc/cpuinfo. ARM's has numbers of maker and part instead of a name.
/// Known ones get their name, "ARM 0x41/0xd4f (Neoverse-V2)"; others are given as they are.
std::string processor_name_in(std::string_view cpuinfo);

/// A key or token, without line ends at its end; may be empty. It is the content of a file, or,
/// without one, the first of these environment variables that is set. Never from the command line,
/// which other users of the computer can read.
/// \throws FileError
std::string read_secret(const std::string& file, std::initializer_list<const char*> variables);

/// Writes to a file (atomically) or, if `path` is "-", to stdout. \throws FileError
void write_output(const std::string& path, const std::string& content);

/// Prints the diagnostics to stderr, a line each, then how many there were of each severity.
void print_diagnostics(const std::vector<Diagnostic>& diagnostics);

/// Parses the command line, runs the callbacks of the named verbs, and turns every exception into a
/// message on stderr and an exit code. `status` is returned if nothing is thrown. Options whose
/// type is a FILE or a DIR refuse an empty value.
int run_program(CLI::App& app, int argc, char** argv, const int& status);

}  // namespace enfilade::apps
