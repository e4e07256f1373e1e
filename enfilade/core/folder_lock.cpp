#include "enfilade/core/folder_lock.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>
#include <cerrno>
#include <system_error>

#include "enfilade/core/errors.h"

namespace enfilade {

FolderLock::FolderLock(const std::filesystem::path& file)
    : descriptor_(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644)) {
  if (descriptor_ < 0) {
    throw FileError(
        fmt::format("{}: cannot write: {}", file.string(), std::generic_category().message(errno)));
  }
  if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
  const int reason = errno;
  ::close(descriptor_);
  // File systems without locks (some network ones) report other errors: goes on without a lock.
  if (reason == EWOULDBLOCK) {
    throw FileError(fmt::format("{}: another process works in this folder", file.string()));
  }
  descriptor_ = -1;
}

FolderLock::~FolderLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

}  // namespace enfilade
