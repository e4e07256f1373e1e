/// \file  A file that grows under another name until it is whole.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace enfilade {

/// `<file>.part`, open for writing. It stays when this object goes, also when the process is
/// killed, unless it was finished or removed: who opens it again goes on from there, or cuts it.
/// One process, and one object, at a time.
class PartFile {
 public:
  /// Opens the part as it is, or makes an empty one. Where `file` is a link, the part lies beside
  /// what it points to. \throws FileError naming the path and the system's reason, if somebody else
  /// writes it just now, or if `file` is there and is no plain file
  explicit PartFile(const std::filesystem::path& file);
  ~PartFile();
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  const std::filesystem::path& path() const noexcept { return part_; }
  std::uint64_t size() const;  ///< bytes. \throws FileError

  // Each throws FileError naming the part and the system's reason.
  void write_at(std::uint64_t offset, std::span<const std::byte> bytes);
  void resize(std::uint64_t bytes);  ///< cuts, or adds zeros
  void synchronise();                ///< waits until all of it is on the disk
  void finish();                     ///< synchronises, and gives the part the name of the file
  void remove() noexcept;

 private:
  void open_locked();
  [[noreturn]] void fail(const char* doing) const;

  std::filesystem::path file_, part_;
  int descriptor_ = -1;
};

}  // namespace enfilade
