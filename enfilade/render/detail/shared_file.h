/// \file  A file of fixed size that several processes map and write, and which of them still run.
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

  std::uint8_t* bytes() const noexcept { return bytes_; }  ///< aligned to a page
  /// Removes the name, if it is still this file's. The memory is freed with the last mapping.
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

/// A process of this machine. Numbers are used again, but not by a process that started at the same
/// time; and each PID namespace (container) has its own.
struct ProcessId {
  std::int32_t number = 0;       ///< 0: none
  std::uint64_t start = 0;       ///< clock ticks since the machine's start
  std::uint64_t name_space = 0;  ///< inode of its PID namespace
  friend bool operator==(const ProcessId&, const ProcessId&) = default;
};

/// The calling process. \throws FileError if /proc cannot be read
ProcessId this_process();

/// False if the process has certainly ended; true also where that cannot be found out, as for a
/// process of another container. A zombie has ended. Any thread.
/// \param here the calling process
bool may_run(const ProcessId& process, const ProcessId& here) noexcept;

}  // namespace enfilade::render::detail
