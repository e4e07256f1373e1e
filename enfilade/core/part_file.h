/// \file  Files that one process at a time writes: under a temporary name, to be continued after a
/// crash. Lock files of folders.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

#include "enfilade/core/mapped_file.h"

namespace enfilade {

/// `<file>.part`, open for writing. finish() renames it to `<file>`. If the object is destroyed or
/// the process killed before, the part stays on the disk; opening it again continues it. One
/// process and one object at a time.
class PartFile {
 public:
  /// Opens the part that exists, or makes an empty one. If `file` is a link, the part lies beside
  /// its target.
  /// \throws FileError naming the path and the system's reason. Also if another object has the part
  /// open, the part is a link, or `file` exists and is not a plain file
  explicit PartFile(const std::filesystem::path& file);
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  const std::filesystem::path& path() const noexcept { return part_; }
  std::uint64_t size() const;  ///< bytes. \throws FileError

  /// Writes bytes at an offset. This and the next three throw FileError naming the part and the
  /// system's reason.
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);
  void resize(std::uint64_t bytes);  ///< truncates, or appends zeros
  void synchronise();                ///< waits until everything is on the disk
  void finish();                     ///< synchronises, and renames the part to the file
  void remove() noexcept;            ///< of the part; the file stays as it was

 private:
  void open_locked();
  [[noreturn]] void fail(const char* doing) const;

  std::filesystem::path file_, part_;
  int descriptor_ = -1;
};

/// Holds the lock while it exists. The system releases it when the process ends, however it ends.
class FolderLock {
 public:
  /// \param file created if it does not exist, and not removed
  /// \throws FileError if another process holds the lock, the file cannot be created, or is a link
  explicit FolderLock(const std::filesystem::path& file);

 private:
  Descriptor descriptor_;
};

}  // namespace enfilade
