/// \file  A file mapped into memory.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>

namespace enfilade {

/// Read-only; the memory is shared by all processes that map the same file. The file may be renamed
/// or removed while it is mapped, but must not be truncated: reading beyond its new end kills the
/// process (SIGBUS). Any thread may read.
class MappedFile {
 public:
  /// \throws FileError naming the path and the system's reason; a folder is not a file
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const std::uint8_t> bytes() const noexcept { return bytes_; }

 private:
  std::span<const std::uint8_t> bytes_;
};

}  // namespace enfilade
