#include "enfilade/render/detail/shared_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <string>
#include <string_view>
#include <system_error>
#include <thread>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/mapped_file.h"
#include "enfilade/core/threads.h"

namespace enfilade::render::detail {
namespace {

constexpr std::uint64_t kMagic = 0x6568636163'6e65;  // "encache"

std::uint64_t mebibytes(std::size_t bytes) { return bytes >> 20U; }

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& why) {
  throw FileError(fmt::format("{}: {}", path.string(), why));
}

[[noreturn]] void fail(const std::filesystem::path& path, const char* what, int reason) {
  fail(path, fmt::format("{}: {}", what, std::generic_category().message(reason)));
}

[[noreturn]] void no_room(const std::filesystem::path& path, std::size_t bytes) {
  fail(path, fmt::format("no room for a shared cache of {} MiB: make it smaller, name a file on "
                         "another disk, or give /dev/shm more (in a container: docker run "
                         "--shm-size={}m)",
                         mebibytes(bytes), 2 * mebibytes(bytes)));
}

// FNV-1a. 0 if the system does not say: then no file is ever taken for an older one.
std::uint64_t boot() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string id;
  if (!std::getline(file, id)) return 0;
  std::uint64_t hash = 0xCBF29CE484222325U;
  for (const char c : id) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001B3U;
  return hash;
}

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

SharedFile::SharedFile(std::filesystem::path path, std::size_t bytes,
                       const std::function<void(std::uint8_t*)>& initialise)
    : path_(std::move(path)), size_(bytes) {
  // Another process may make the file, or remove it, between the two; and may have the room that
  // is missing here for a file that it gives up, because ours is complete before.
  constexpr int kTries = 50;
  for (int k = 0; k < kTries; ++k) {
    if (open_existing() || make(initialise)) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  no_room(path_, size_);
}

SharedFile::~SharedFile() { unmap(); }

void SharedFile::unmap() noexcept {
  if (bytes_ != nullptr) munmap(bytes_, size_);
  bytes_ = nullptr;
}

void SharedFile::map(int file) {
  struct stat status {};
  if (fstat(file, &status) != 0) fail(path_, "cannot be examined", errno);
  device_ = status.st_dev;
  inode_ = status.st_ino;
  void* memory = mmap(nullptr, size_, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (memory == MAP_FAILED) fail(path_, "cannot be mapped", errno);
  bytes_ = static_cast<std::uint8_t*>(memory);
}

// False if there is none.
bool SharedFile::open_existing() {
  const Descriptor file(open(path_.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (file.number() < 0 && errno == ENOENT) return false;
  if (file.number() < 0) fail(path_, "cannot be opened", errno);
  struct stat status {};
  if (fstat(file.number(), &status) != 0) fail(path_, "cannot be examined", errno);
  if (!S_ISREG(status.st_mode)) fail(path_, "no regular file, which a shared cache has to be");
  if (status.st_uid != geteuid()) {
    fail(path_,
         fmt::format("belongs to user {}, not {}: name another file", status.st_uid, geteuid()));
  }
  if ((status.st_mode & 077U) != 0) {
    fail(path_, fmt::format("others may use it (mode {:o}); a shared cache has mode 600: remove it",
                            status.st_mode & 0777U));
  }
  SharedFileHead head;
  if (pread(file.number(), &head, sizeof(head), 0) != sizeof(head) || head.magic != kMagic) {
    fail(path_, "not a shared cache of Enfilade: name another file, or remove it");
  }
  if (head.version != kVersion) {
    fail(path_, fmt::format("a shared cache of version {}, not {}: name another file, or remove "
                            "it when no process uses it",
                            head.version, kVersion));
  }
  // On a disk it outlives a restart; then no process can be using it.
  if (head.boot != boot()) {
    if (unlink(path_.c_str()) != 0 && errno != ENOENT) fail(path_, "cannot be removed", errno);
    return false;
  }
  if (static_cast<std::uint64_t>(status.st_size) != head.bytes) {
    fail(path_,
         fmt::format("{} bytes, but {} when it was made: remove it", status.st_size, head.bytes));
  }
  if (head.bytes != size_) {
    fail(path_, fmt::format("a shared cache of {} MiB, not {} MiB: give the same size to all "
                            "processes, or name another file",
                            mebibytes(head.bytes), mebibytes(size_)));
  }
  map(file.number());
  return true;
}

// False if there is one meanwhile, or no room.
bool SharedFile::make(const std::function<void(std::uint8_t*)>& initialise) {
  // Without a name: if this process is killed, nothing is left behind.
  const std::filesystem::path folder = path_.has_parent_path() ? path_.parent_path() : ".";
  const Descriptor file(open(folder.c_str(), O_TMPFILE | O_RDWR | O_CLOEXEC, 0600));
  if (file.number() < 0) fail(path_, "cannot be made", errno);
  const std::uint64_t memory = available_memory();  // 0: unknown
  if (memory > 0 && size_ > memory) no_room(path_, size_);
  struct statvfs space {};
  if (fstatvfs(file.number(), &space) == 0 && space.f_bavail * space.f_frsize < size_) return false;
  // All of it now: later, a missing page would kill the process that touches it.
  const int refused = posix_fallocate(file.number(), 0, static_cast<off_t>(size_));
  if (refused == ENOSPC) return false;
  if (refused != 0) fail(path_, "cannot be made", refused);
  map(file.number());
  try {
    const SharedFileHead head{kMagic, kVersion, size_, boot()};
    std::memcpy(bytes_, &head, sizeof(head));
    initialise(bytes_);
    const std::string own = fmt::format("/proc/self/fd/{}", file.number());
    if (linkat(AT_FDCWD, own.c_str(), AT_FDCWD, path_.c_str(), AT_SYMLINK_FOLLOW) == 0) return true;
    if (errno != EEXIST) fail(path_, "cannot be made", errno);
  } catch (...) {
    unmap();
    throw;
  }
  unmap();
  return false;
}

void SharedFile::remove() const noexcept {
  struct stat status {};
  const bool named =
      lstat(path_.c_str(), &status) == 0 && status.st_dev == device_ && status.st_ino == inode_;
  if (named) unlink(path_.c_str());
}

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
