/// \file  A path for bytes in memory, for readers that take a path.
#pragma once
#include <sys/mman.h>
#include <unistd.h>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "enfilade/core/check.h"

namespace enfilade::fuzz {

/// A file that is in memory only, and gone with this object.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view bytes)
      : MemoryFile(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()) {}
  MemoryFile(const std::uint8_t* data, std::size_t size) : descriptor_(memfd_create("fuzz", 0)) {
    EN_CHECK(descriptor_ >= 0);
    EN_CHECK(write(descriptor_, data, size) == static_cast<ssize_t>(size));
  }
  ~MemoryFile() { close(descriptor_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string path() const { return "/proc/self/fd/" + std::to_string(descriptor_); }

 private:
  int descriptor_;
};

}  // namespace enfilade::fuzz
