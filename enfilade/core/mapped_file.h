/// \file  A file as memory.
#pragma once
#include <cstdint>
#include <filesystem>
#include <span>

namespace enfilade {

/// Read-only, shared with every process that maps the same file. The file may be renamed or removed
/// meanwhile; it must not be cut shorter: reading beyond its new end kills the process (SIGBUS).
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
