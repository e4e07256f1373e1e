#include "enfilade/core/part_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "enfilade/core/errors.h"

namespace enfilade {
namespace fs = std::filesystem;
namespace {

// A renamed file survives a power cut only after its folder has been synchronised. Errors are
// ignored: some file systems cannot synchronise folders.
void synchronise_folder(const fs::path& folder) {
  const int descriptor =
      open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (descriptor < 0) return;
  fsync(descriptor);
  close(descriptor);
}

}  // namespace

void PartFile::fail(const char* doing) const {
  throw FileError(fmt::format("{}: cannot be {}: {}", part_.string(), doing,
                              std::generic_category().message(errno)));
}

PartFile::PartFile(const fs::path& file) {
  std::error_code ignored;
  file_ = fs::is_symlink(file, ignored) ? fs::weakly_canonical(file, ignored) : file;
  part_ = file_.string() + ".part";
  const fs::file_status status = fs::status(file_, ignored);
  if (fs::exists(status) && !fs::is_regular_file(status)) {
    throw FileError(file.string() + ": cannot be written: it is there and is no plain file");
  }
  open_locked();
}

PartFile::~PartFile() {
  if (descriptor_ >= 0) close(descriptor_);  // releases the lock too
}

void PartFile::open_locked() {
  while (true) {
    descriptor_ = open(part_.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor_ < 0 && errno == ELOOP) {
      throw FileError(part_.string() + ": cannot be written: a link stands there; remove it");
    }
    if (descriptor_ < 0) fail("written");
    if (flock(descriptor_, LOCK_EX | LOCK_NB) != 0) {
      const int reason = errno;
      close(descriptor_);
      errno = reason;
      if (reason != EWOULDBLOCK) fail("locked");
      throw FileError(fmt::format("{}: another process is writing it just now", part_.string()));
    }
    // The process that held the lock may have renamed the part meanwhile: then the open file is the
    // finished one.
    struct stat opened {
    }, named{};
    if (fstat(descriptor_, &opened) == 0 && lstat(part_.c_str(), &named) == 0 &&
        opened.st_ino == named.st_ino && opened.st_dev == named.st_dev) {
      return;
    }
    close(descriptor_);
  }
}

std::uint64_t PartFile::size() const {
  struct stat status {};
  if (fstat(descriptor_, &status) != 0) fail("read");
  return static_cast<std::uint64_t>(status.st_size);
}

void PartFile::write_at(std::uint64_t offset, std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written =
        pwrite(descriptor_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (written < 0) {
      if (errno == EINTR) continue;
      fail("written");
    }
    offset += static_cast<std::uint64_t>(written);
    bytes = bytes.subspan(static_cast<std::size_t>(written));
  }
}

void PartFile::resize(std::uint64_t bytes) {
  if (ftruncate(descriptor_, static_cast<off_t>(bytes)) != 0) fail("written");
}

void PartFile::synchronise() {
  if (fsync(descriptor_) != 0) fail("written");
}

void PartFile::finish() {
  synchronise();
  if (std::rename(part_.c_str(), file_.c_str()) != 0) fail("renamed");
  synchronise_folder(file_.parent_path());
}

void PartFile::remove() noexcept { unlink(part_.c_str()); }

FolderLock::FolderLock(const std::filesystem::path& file)
    : descriptor_(::open(file.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0644)) {
  if (descriptor_.number() < 0) {
    throw FileError(
        fmt::format("{}: cannot write: {}", file.string(), std::generic_category().message(errno)));
  }
  // File systems without locks (some network ones) report other errors: goes on without a lock.
  if (::flock(descriptor_.number(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    throw FileError(fmt::format("{}: another process works in this folder", file.string()));
  }
}

}  // namespace enfilade
