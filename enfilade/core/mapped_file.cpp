#include "enfilade/core/mapped_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <system_error>

#include "enfilade/core/errors.h"

namespace enfilade {
namespace {

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& reason) {
  throw FileError(fmt::format("{}: cannot be read: {}", path.string(), reason));
}
[[noreturn]] void fail(const std::filesystem::path& path, int reason) {
  fail(path, std::generic_category().message(reason));
}

}  // namespace

MappedFile::MappedFile(const std::filesystem::path& path) {
  // Without waiting for a pipe's writer.
  const Descriptor file(open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
  if (file.number() < 0) fail(path, errno);
  struct stat status {};
  if (fstat(file.number(), &status) != 0) fail(path, errno);
  if (S_ISDIR(status.st_mode)) fail(path, EISDIR);
  if (!S_ISREG(status.st_mode)) fail(path, "not a plain file");
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size == 0) return;  // mmap refuses empty files
  void* memory = mmap(nullptr, size, PROT_READ, MAP_SHARED, file.number(), 0);
  if (memory == MAP_FAILED) fail(path, errno);
  bytes_ = {static_cast<const std::uint8_t*>(memory), size};
}

MappedFile::~MappedFile() {
  if (!bytes_.empty()) munmap(const_cast<std::uint8_t*>(bytes_.data()), bytes_.size());
}

void MappedFile::give_back(std::size_t offset, std::size_t count) const noexcept {
  // Linux maps the neighbours of a page that is touched too, as far as this (fault_around_bytes).
  constexpr std::size_t kAround = 64U << 10U;
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  const std::size_t begin = (offset - std::min(offset, kAround)) / page * page;
  const std::size_t end = std::min(offset + count + kAround, bytes_.size());
  if (begin >= end) return;
  // Advice: if the system refuses it, the pages stay, and nothing is wrong.
  madvise(const_cast<std::uint8_t*>(bytes_.data()) + begin, end - begin, MADV_DONTNEED);
}

Descriptor::~Descriptor() {
  if (number_ >= 0) close(number_);
}

}  // namespace enfilade
