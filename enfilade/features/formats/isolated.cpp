#include "enfilade/features/formats/isolated.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <array>
#include <cerrno>
#include <csignal>
#include <string_view>
#include <system_error>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/features/formats/stored_arrays.h"

namespace enfilade::features::formats {
namespace {

[[noreturn]] void fail(const std::string& what, int reason) {
  throw FileError(fmt::format("{}: {}", what, std::generic_category().message(reason)));
}

// What a copy tells the first process: a kind, then texts with a 0 behind each.
constexpr char kDone = 'd', kInvalid = 'i', kUnreadable = 'u';

bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(descriptor, text.data(), text.size());
    if (written < 0 && errno != EINTR) return false;
    if (written > 0) text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

std::string read_all(int descriptor) {
  std::string text;
  std::array<char, 4096> part;
  while (true) {
    const ssize_t got = read(descriptor, part.data(), part.size());
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return text;
    text.append(part.data(), static_cast<std::size_t>(got));
  }
}

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
  return outcome;  // of anything else: nothing, as of a crash
}

[[noreturn]] void be_the_copy(int result, const std::function<void()>& work) {
  // A crash is an answer here: no handler, dump or message of the first process' should see it.
  for (const int signal : {SIGSEGV, SIGBUS, SIGABRT, SIGFPE, SIGILL}) std::signal(signal, SIG_DFL);
  const rlimit none{0, 0};
  setrlimit(RLIMIT_CORE, &none);
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  bool told = false;
  try {
    told = write_all(result, outcome_of(work));
  } catch (...) {
  }
  _exit(told ? 0 : 1);  // nothing that the first process does at its end
}

std::vector<std::string> texts_of(std::string_view outcome) {
  std::vector<std::string> texts;
  while (!outcome.empty()) {
    const std::size_t end = std::min(outcome.find('\0'), outcome.size());
    texts.emplace_back(outcome.substr(0, end));
    outcome.remove_prefix(std::min(end + 1, outcome.size()));
  }
  return texts;
}

void rethrow(const std::string& outcome) {
  const std::vector<std::string> texts = texts_of(std::string_view(outcome).substr(1));
  if (outcome[0] == kUnreadable && !texts.empty()) throw FileError(texts[0]);
  std::vector<Diagnostic> diagnostics;
  for (std::size_t i = 0; i + 4 <= texts.size(); i += 4) {
    diagnostics.push_back({Severity::kError, texts[i], texts[i + 1], texts[i + 2], texts[i + 3]});
  }
  throw InvalidInput(std::move(diagnostics));
}

}  // namespace

SharedMemory::SharedMemory() : descriptor_(memfd_create("enfilade", MFD_CLOEXEC)) {
  if (descriptor_ < 0) fail("memory for a file's content", errno);
}

SharedMemory::~SharedMemory() { close(descriptor_); }

void SharedMemory::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written =
        pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0 && errno != EINTR) fail("memory for a file's content", errno);
    if (written <= 0) continue;
    offset += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

std::string SharedMemory::path() const { return fmt::format("/proc/self/fd/{}", descriptor_); }

void run_isolated(const std::string& file, const std::string& code,
                  const std::function<void()>& work) {
  std::array<int, 2> ends{};
  if (pipe2(ends.data(), O_CLOEXEC) != 0) fail(file + ": cannot be read", errno);
  const pid_t copy = fork();
  const int reason = errno;
  if (copy == 0) {
    close(ends[0]);
    be_the_copy(ends[1], work);
  }
  close(ends[1]);
  std::string outcome;
  if (copy > 0) outcome = read_all(ends[0]);
  close(ends[0]);
  if (copy < 0) fail(file + ": cannot be read", reason);
  while (waitpid(copy, nullptr, 0) < 0 && errno == EINTR) {
  }
  if (outcome == std::string(1, kDone)) return;
  if (!outcome.empty()) rethrow(outcome);
  refuse(file, "", code, "so damaged that its library does not come to an end with it");
}

}  // namespace enfilade::features::formats
