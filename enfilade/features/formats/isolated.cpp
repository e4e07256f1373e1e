#include "enfilade/features/formats/isolated.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cerrno>
#include <csignal>
#include <ranges>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"

namespace enfilade::features::formats {
namespace {

[[noreturn]] void fail(const std::string& what, int reason) {
  throw FileError(fmt::format("{}: {}", what, std::generic_category().message(reason)));
}

// What the copy tells the first process: one of these letters, then texts, each followed by a 0.
constexpr char kDone = 'd', kInvalid = 'i', kUnreadable = 'u';

std::string outcome_of(const std::function<void()>& work) {
  std::string outcome;
  try {
    work();
    return {kDone};
  } catch (const InvalidInput& error) {
    outcome = kInvalid;
    for (const Diagnostic& d : error.diagnostics()) {
      for (const std::string& text : {d.file, d.where, d.code, d.message}) {
        outcome += text;
        outcome += '\0';
      }
    }
  } catch (const FileError& error) {
    outcome = kUnreadable;
    outcome += error.what();
    outcome += '\0';
  }
  return outcome;
}

[[noreturn]] void be_the_copy(SharedMemory& outcome, const std::function<void()>& work) {
  // A crash only tells that the file is damaged: handlers of the first process must not run, and no
  // core dump and no message should appear.
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL}) std::signal(signal, SIG_DFL);
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  try {
    const std::string told = outcome_of(work);
    outcome.write_at(0, std::as_bytes(std::span(told)));
  } catch (...) {  // the outcome stays empty, as after a crash
  }
  _exit(0);  // without the first process's atexit handlers and static destructors
}

void rethrow(std::string_view outcome) {
  std::vector<std::string> texts;
  for (const auto text : std::views::split(outcome.substr(1), '\0')) {
    texts.emplace_back(text.begin(), text.end());
  }
  if (outcome[0] == kUnreadable && !texts.empty()) throw FileError(texts[0]);
  std::vector<Diagnostic> diagnostics;
  for (std::size_t i = 0; i + 4 <= texts.size(); i += 4) {
    diagnostics.push_back({Severity::kError, texts[i], texts[i + 1], texts[i + 2], texts[i + 3]});
  }
  throw InvalidInput(std::move(diagnostics));
}

}  // namespace

SharedMemory::SharedMemory(std::string file)
    : file_(std::move(file)), descriptor_(memfd_create("enfilade", MFD_CLOEXEC)) {
  if (descriptor_ < 0) fail(file_ + ": shared memory for its content cannot be made", errno);
}

SharedMemory::~SharedMemory() { close(descriptor_); }

void SharedMemory::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written =
        pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno != EINTR) {
      fail(file_ + ": shared memory for its content cannot be written", errno);
    }
    if (written <= 0) continue;
    offset += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

std::string SharedMemory::path() const { return fmt::format("/proc/self/fd/{}", descriptor_); }

void run_isolated(const std::string& file, const std::string& code,
                  const std::function<void()>& work) {
  SharedMemory outcome(file);
  const pid_t copy = fork();
  if (copy < 0) fail(file + ": no process can be started to read it", errno);
  if (copy == 0) be_the_copy(outcome, work);
  while (waitpid(copy, nullptr, 0) < 0 && errno == EINTR) {
  }
  const std::string told = read_file(outcome.path());
  if (told == std::string(1, kDone)) return;
  if (!told.empty()) rethrow(told);
  refuse(file, "", code, "damaged: the process that read it crashed or was killed");
}

}  // namespace enfilade::features::formats
