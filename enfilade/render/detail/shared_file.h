/// \file  A file of fixed size that several processes map and write.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>

namespace enfilade::render::detail {

/// What each such file begins with.
struct SharedFileHead {
  std::uint64_t magic = 0, version = 0;
  std::uint64_t bytes = 0;  ///< of the file
  std::uint64_t boot = 0;   ///< a hash of the machine's boot id: locks and pins do not outlive it
};

/// Mapped, readable and writable. The file appears under its name only when it is complete and all
/// its memory is there, so that no access to it can fail later, whatever else fills the disk. It
/// must not be truncated while it is mapped, as no mapped file; it may be removed or renamed.
class SharedFile {
 public:
  /// Opens the file, or makes it. \param bytes of the file
  /// \param initialise is called with the new file's bytes, all 0 after the head
  /// \throws FileError naming the path, and what to do, if there is another kind of file, one of
  /// another user, version or size, or no room for it
  SharedFile(std::filesystem::path path, std::size_t bytes,
             const std::function<void(std::uint8_t*)>& initialise);
  ~SharedFile();
  SharedFile(const SharedFile&) = delete;
  SharedFile& operator=(const SharedFile&) = delete;

  /// Of the files' layout, cells (image/face_cells.h) included: a new one for each change.
  static constexpr std::uint64_t kVersion = 1;

  const std::filesystem::path& path() const noexcept { return path_; }
  std::uint8_t* bytes() const noexcept { return bytes_; }  ///< aligned to a page
  std::size_t size() const noexcept { return size_; }
  /// Whether the path still names this file.
  bool is_named() const noexcept;
  /// Removes the name, if it is this file's. The memory is freed when nobody maps it any more.
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
