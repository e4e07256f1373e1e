/// \file  Files that the system has opened or mapped into memory.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace enfilade {

/// Read-only; the memory is shared by all processes that map the same file. The file may be renamed
/// or removed while it is mapped, but must not be truncated: reading beyond its new end kills the
/// process (SIGBUS). Any thread may read.
class MappedFile {
 public:
  /// \throws FileError naming the path and the system's reason; a folder, pipe or device is no file
  explicit MappedFile(const std::filesystem::path& path);
  ~MappedFile();
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;

  std::span<const std::uint8_t> bytes() const noexcept { return bytes_; }
  /// Takes these bytes, and up to 64 KiB on either side, out of this process's memory. They stay
  /// readable, also for threads that are reading them: the next access gets them from the system's
  /// cache or the file. For programs that read much, and the same seldom.
  /// \pre offset + count <= bytes().size()
  void give_back(std::size_t offset, std::size_t count) const noexcept;

 private:
  std::span<const std::uint8_t> bytes_;
};

/// Closes a file descriptor in its destructor. Does nothing for a negative one, which stands for a
/// failure of open(). Not to be used by several threads at once.
class Descriptor {
 public:
  /// Takes over `number`, as open() gives it.
  explicit Descriptor(int number) : number_(number) {}
  ~Descriptor();
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  /// For system calls; negative if open() failed.
  int number() const noexcept { return number_; }

 private:
  int number_;
};

}  // namespace enfilade
