/// \file  A file of fixed size that several processes map and write.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

namespace enfilade::render::detail {

/// The beginning of each such file.
struct SharedFileHead {
  std::uint64_t magic = 0, version = 0;
  std::uint64_t bytes = 0;  ///< of the file
  std::uint64_t boot = 0;   ///< a hash of the machine's boot id: locks and pins do not outlive it
};

/// A file mapped readable and writable. It appears under its name only when it is complete and all
/// its memory is allocated. So no access to it can fail later, even on a full disk. While it is
/// mapped it must not be truncated, like any mapped file; it may be removed or renamed.
class SharedFile {
 public:
  /// Opens the file, or makes it. \param bytes of the file
  /// \param initialise is called with the new file's bytes, all 0 after the head
  /// \throws FileError naming the path and the remedy, for another kind of file, one of another
  /// user, version or size, or if the disk is full
  SharedFile(std::filesystem::path path, std::size_t bytes,
             const std::function<void(std::uint8_t*)>& initialise);
  ~SharedFile();
  SharedFile(const SharedFile&) = delete;
  SharedFile& operator=(const SharedFile&) = delete;

  /// Version of the files' layout, cells (image/face_cells.h) included: a new one for each change.
  static constexpr std::uint64_t kVersion = 1;

  const std::filesystem::path& path() const noexcept { return path_; }
  std::uint8_t* bytes() const noexcept { return bytes_; }  ///< aligned to a page
  std::size_t size() const noexcept { return size_; }
  /// Whether the path still names this file.
  bool is_named() const noexcept;
  /// Removes the name, if it is this file's. The memory is freed with the last mapping.
  void remove() const noexcept;

 private:
  bool open_existing();
  bool make(const std::function<void(std::uint8_t*)>& initialise);
  void map(int file);
  void unmap() noexcept;

  std::filesystem::path path_;
  std::size_t size_;
  std::uint8_t* bytes_ = nullptr;
  std::uint64_t device_ = 0, inode_ = 0;
};

}  // namespace enfilade::render::detail
