/// \file  gzip of texts in memory, and text files that may be packed with it.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace enfilade {

/// gzip as in RFC 1952. \param level 1 (fast) to 9 (small)
std::string gzip(std::string_view text, int level);
/// Its inverse. \param most bytes of the text
/// \throws Error for bytes that gzip() did not write, and for a text of more than `most` bytes;
/// memory is never taken for more
std::string gunzip(std::string_view packed, std::size_t most);

/// Largest size of a packed text file's content: ten times the largest annotations of the field
/// (RxR's guide).
inline constexpr std::size_t kMostTextBytes = std::size_t{1} << 32U;
/// The content of a text file, unpacked if it begins as gzip does, whatever its name is.
/// \throws FileError naming the path: as read_file(), and for gzip that is damaged or holds more
/// than `most` bytes
std::string read_text_file(const std::filesystem::path& path, std::size_t most = kMostTextBytes);

/// Unpacks gzip as it arrives, in 100 kB of memory. Belongs to one thread.
class Gunzip {
 public:
  /// Gets the next bytes that came out.
  using Take = std::function<void(std::string_view)>;

  Gunzip();
  ~Gunzip();
  Gunzip(const Gunzip&) = delete;
  Gunzip& operator=(const Gunzip&) = delete;

  /// Unpacks the next bytes and passes them to `take`, at most 32 KiB at a time. An exception of
  /// take() ends the unpacking. \throws Error if the bytes are not gzip, or go on after its end
  void add(std::string_view packed, const Take& take);
  bool ended() const noexcept;  ///< whether the end of the text has come

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade
