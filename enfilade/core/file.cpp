#include "enfilade/core/file.h"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <fstream>
#include <iterator>
#include <new>
#include <system_error>
#include <vector>

#include "enfilade/core/detail/replace_file.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/mapped_file.h"
#include "enfilade/core/numbers.h"

namespace enfilade {
namespace fs = std::filesystem;
namespace {

// Ending of a file that is being written, before the process id: "a.json.part4711".
constexpr std::string_view kPart = ".part";

[[noreturn]] void fail(const fs::path& path, const char* doing, int reason) {
  throw FileError(path.string() + ": cannot " + doing + ": " +
                  std::generic_category().message(reason));
}

// A full disk may be reported only when the file is closed, so that is part of writing.
void write_and_close(int file, std::string_view content, const fs::path& shown) {
  int reason = 0;
  while (!content.empty() && reason == 0) {
    const ssize_t written = ::write(file, content.data(), content.size());
    if (written >= 0) {
      content.remove_prefix(static_cast<std::size_t>(written));
    } else if (errno != EINTR) {
      reason = errno;
    }
  }
  if (::close(file) != 0 && reason == 0 && errno != EINTR) reason = errno;
  if (reason != 0) fail(shown, "write", reason);
}

// Whether a process has ended that its parent has not asked for yet. Those of a killed job stay so
// until the machine's first process asks, which may be never in a container.
bool is_zombie(pid_t process) {
  std::ifstream file("/proc/" + std::to_string(process) + "/stat");
  const std::string line{std::istreambuf_iterator<char>(file), {}};
  const std::size_t state = line.rfind(") ");  // behind the program's name, which may hold anything
  return state != std::string::npos && (line[state + 2] == 'Z' || line[state + 2] == 'X');
}

// Whether a temporary file's process still runs on this machine.
bool is_being_written(const fs::path& part) {
  const std::string ending = part.extension().string();
  const auto process = parse_number<pid_t>(std::string_view(ending).substr(kPart.size()));
  // One of our own number was left by a process before: containers give the same number again.
  return process && *process > 0 && *process != ::getpid() &&
         (::kill(*process, 0) == 0 || errno == EPERM) && !is_zombie(*process);
}

}  // namespace

bool file_exists(const fs::path& path) {
  std::error_code code;
  const bool exists = fs::exists(path, code);
  if (code) fail(path, "open", code.value());
  return exists;
}

std::string read_file(const fs::path& path, std::size_t most) try {
  // Without waiting: open() itself would wait for a pipe's writer.
  const Descriptor file(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (file.number() < 0) fail(path, "open", errno);
  struct stat status {};
  if (::fstat(file.number(), &status) != 0) fail(path, "read", errno);
  if (S_ISDIR(status.st_mode)) fail(path, "read", EISDIR);
  const bool plain = S_ISREG(status.st_mode), fifo = S_ISFIFO(status.st_mode);
  if (!plain && !fifo) most = std::min(most, kMostDeviceBytes);
  const auto too_large = [&] {
    throw FileError(fmt::format("{}: cannot read: more than {} bytes", path.string(), most));
  };
  const std::size_t size = plain ? static_cast<std::size_t>(status.st_size) : 0;
  if (size > most) too_large();
  constexpr std::size_t kPiece = std::size_t{1} << 16U, kMostOfOneRead = std::size_t{1} << 30U;
  constexpr int kPatience = 2000;  // milliseconds
  std::string content;
  content.reserve(size + 1);
  for (;;) {
    pollfd one{file.number(), POLLIN, 0};
    const bool silent = !plain && ::poll(&one, 1, kPatience) == 0;
    const std::size_t have = content.size();
    // One byte over the size: it finds the end of an ordinary file, and room is reserved for it.
    const std::size_t step =
        have <= size && plain ? std::min(size + 1 - have, kMostOfOneRead) : kPiece;
    content.resize(have + step);
    const ssize_t got = ::read(file.number(), content.data() + have, step);
    const int reason = errno;
    content.resize(have + static_cast<std::size_t>(std::max<ssize_t>(got, 0)));
    if (content.size() > most) too_large();
    if (got > 0 || (got < 0 && (reason == EAGAIN || reason == EINTR))) continue;
    if (got < 0) fail(path, "read", reason);
    // A writer may have come and gone between the two calls.
    if (!silent || !fifo || !content.empty()) return content;
    throw FileError(path.string() + ": cannot read: a pipe that no program writes to");
  }
} catch (const std::bad_alloc&) {
  fail(path, "read", ENOMEM);
}

void check_plain_file(const fs::path& path) {
  std::error_code ignored;  // who opens the file says what is wrong
  const fs::file_status status = fs::status(path, ignored);
  if (!fs::exists(status) || fs::is_regular_file(status)) return;
  if (fs::is_directory(status)) fail(path, "read", EISDIR);
  throw FileError(path.string() + ": cannot read: not a plain file");
}

void write_file_atomically(const fs::path& path, std::string_view content) {
  std::error_code code;
  // Before links are followed by name: that of a pipe leads nowhere.
  const fs::file_status status = fs::status(path, code);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    if (fs::is_directory(status)) fail(path, "write", EISDIR);
    const int file = ::open(path.c_str(), O_WRONLY | O_CLOEXEC | O_TRUNC);
    if (file < 0) fail(path, "write", errno);
    return write_and_close(file, content, path);
  }
  const fs::path target = fs::is_symlink(path, code) ? fs::weakly_canonical(path, code) : path;
  const fs::path parent = target.parent_path();
  const Descriptor folder(::open(parent.empty() ? "." : parent.c_str(), detail::kOpenFolder));
  if (folder.number() < 0) fail(path, "write", errno);
  detail::replace_file(folder.number(), target.filename().string(), content, path);
}

namespace detail {

void replace_file(int folder, const std::string& name, std::string_view content,
                  const fs::path& shown) {
  const std::string part = name + std::string(kPart) + std::to_string(::getpid());
  ::unlinkat(folder, part.c_str(), 0);  // of a killed process that had this number, or planted
  const int file =
      ::openat(folder, part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (file < 0) fail(shown, "write", errno);
  try {
    write_and_close(file, content, shown);
    struct stat status {};
    // Renaming over a folder would fail with a reason that does not name it.
    const bool exists = ::fstatat(folder, name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0;
    if (exists && S_ISDIR(status.st_mode)) fail(shown, "write", EISDIR);
    if (::renameat(folder, part.c_str(), folder, name.c_str()) != 0) fail(shown, "write", errno);
  } catch (const FileError&) {
    ::unlinkat(folder, part.c_str(), 0);
    throw;
  }
}

int list_names(int folder, std::vector<std::string>& names) {
  // Opened anew: `folder` may be no more than a place, and closedir() closes what it lists.
  const int number = ::openat(folder, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  DIR* const list = number < 0 ? nullptr : ::fdopendir(number);
  if (list == nullptr) {
    const int reason = errno;
    if (number >= 0) ::close(number);
    return reason;
  }
  errno = 0;
  while (const dirent* entry = ::readdir(list)) {
    const std::string_view name = entry->d_name;
    if (name != "." && name != "..") names.emplace_back(name);
    errno = 0;
  }
  const int reason = errno;
  ::closedir(list);
  return reason;
}

void remove_unfinished(int folder, std::string_view ending, const fs::path& shown) {
  std::vector<std::string> names;
  list_names(folder, names);  // one that cannot be read holds nothing of ours
  for (const std::string& name : names) {
    const fs::path path = name;
    struct stat status {};
    if (is_unfinished(path) && path.stem().string().ends_with(ending) &&
        ::fstatat(folder, name.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 &&
        S_ISREG(status.st_mode) && !is_being_written(path) &&
        ::unlinkat(folder, name.c_str(), 0) != 0 && errno != ENOENT) {
      fail(shown / path, "remove", errno);
    }
  }
}

}  // namespace detail

void make_folder(const fs::path& path) {
  std::error_code code;
  fs::create_directories(path, code);
  if (code) fail(path, "make the folder", code.value());
}

bool is_unfinished(const fs::path& path) {
  const std::string ending = path.extension().string();
  return ending.size() > kPart.size() && ending.starts_with(kPart) &&
         ending.find_first_not_of("0123456789", kPart.size()) == std::string::npos;
}

void remove_unfinished(const fs::path& folder, std::string_view ending) {
  const Descriptor there(::open(folder.empty() ? "." : folder.c_str(), detail::kOpenFolder));
  if (there.number() >= 0) detail::remove_unfinished(there.number(), ending, folder);
}

}  // namespace enfilade
