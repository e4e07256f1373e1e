#include "enfilade/render/detail/process_id.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <string_view>

#include "enfilade/core/errors.h"

namespace enfilade::render::detail {
namespace {

enum class Answer { kFound, kGone, kUnknown };

struct Life {
  bool ended = false;
  std::uint64_t start = 0;
};

// What follows the program's name, which may hold anything, in /proc/PID/stat (proc(5)).
bool parse(std::string_view text, Life& life) {
  const std::size_t name_end = text.rfind(')');
  if (name_end == std::string_view::npos) return false;
  text.remove_prefix(name_end + 1);
  constexpr std::size_t kThreads = 17, kStart = 19;  // counted from the state, which is the first
  std::uint64_t threads = 1;
  char state = ' ';
  for (std::size_t field = 0; field <= kStart; ++field) {
    const std::size_t begin = text.find_first_not_of(' ');
    if (begin == std::string_view::npos) return false;
    text.remove_prefix(begin);
    const std::string_view word = text.substr(0, text.find(' '));
    text.remove_prefix(word.size());
    if (field == 0) state = word[0];
    std::uint64_t* number = field == kThreads ? &threads : field == kStart ? &life.start : nullptr;
    if (number == nullptr) continue;
    if (std::from_chars(word.data(), word.data() + word.size(), *number).ec != std::errc()) {
      return false;
    }
  }
  // A main thread that has ended is a zombie too, while others run on.
  life.ended = (state == 'Z' || state == 'X') && threads <= 1;
  return true;
}

Answer look_up(std::int32_t number, Life& life) noexcept {
  // By way of its first thread, whose file says the same: emulated by qemu-user, a process reads
  // another start in its own /proc/PID/stat than all others do.
  std::array<char, 48> path{};
  std::snprintf(path.data(), path.size(), "/proc/%d/task/%d/stat", number, number);
  const int file = open(path.data(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return errno == ENOENT ? Answer::kGone : Answer::kUnknown;
  std::array<char, 1024> text{};
  const ssize_t count = read(file, text.data(), text.size());
  const int reason = errno;
  close(file);
  if (count < 0) return reason == ESRCH ? Answer::kGone : Answer::kUnknown;
  const std::string_view all(text.data(), static_cast<std::size_t>(count));
  return parse(all, life) ? Answer::kFound : Answer::kUnknown;
}

}  // namespace

ProcessId this_process() {
  const std::int32_t number = getpid();
  Life life;
  struct stat name_space {};
  if (look_up(number, life) != Answer::kFound || stat("/proc/self/ns/pid", &name_space) != 0) {
    throw FileError("/proc/self: cannot be read, but a shared cache needs it to tell processes");
  }
  return {number, life.start, name_space.st_ino};
}

bool may_run(const ProcessId& process, const ProcessId& here) noexcept {
  if (process.name_space != here.name_space) return true;
  Life life;
  switch (look_up(process.number, life)) {
    case Answer::kGone:
      return false;
    case Answer::kUnknown:
      return true;
    case Answer::kFound:
      return life.start == process.start && !life.ended;
  }
  return true;
}

}  // namespace enfilade::render::detail
