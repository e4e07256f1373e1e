/// \file  gzip of texts in memory, and text files that may be packed with it.
#pragma once
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "enfilade/core/mapped_file.h"

namespace enfilade {

/// How gzip begins; no JSON and no text of UTF-8 does.
inline constexpr std::string_view kGzipMark = "\x1f\x8b";

/// gzip as in RFC 1952. \param level 1 (fast) to 9 (small)
std::string gzip(std::string_view text, int level);
/// Its inverse. Several members (RFC 1952, 2.2) are one text; `cat a.gz b.gz`, bgzip and parallel
/// writers make such files. Zeros behind a member are padding. \param most bytes of the text
/// \throws Error for damaged bytes, for other bytes behind the end, and for a text of more than
/// `most` bytes; memory is never taken for more
std::string gunzip(std::string_view packed, std::size_t most);

/// Largest size of a packed text file's content: ten times the largest annotations of the field
/// (RxR's guide).
inline constexpr std::size_t kMostTextBytes = std::size_t{1} << 32U;
/// Bytes of content that a packed text file may always have.
inline constexpr std::size_t kAlwaysUnpacked = std::size_t{1} << 26U;
/// Times its own size that a packed text file's content may have, if that is more than
/// kAlwaysUnpacked. Annotations stay below a third of it; a file of one repeated byte has 1000
/// times.
inline constexpr std::size_t kMostPacking = 100;
/// The file; where it is not there, the same packed (`x.json.gz` for `x.json`) or unpacked
/// (`x.json` for `x.json.gz`). The file's own name if neither is there. All readers of text files
/// below open what this finds.
std::filesystem::path find_text_file(const std::filesystem::path& path);
/// What a file's name has before `ending`: "a" of "some/a.json" and of "some/a.json.gz" for
/// ".json". No value for other names.
std::optional<std::string> name_before(const std::filesystem::path& file, std::string_view ending);
/// The content of a text file, unpacked if it begins as gzip does, whatever its name is.
/// \throws FileError naming the path: as read_file(), and for gzip that is damaged, or holds more
/// than `most` bytes or than its own size allows
std::string read_text_file(const std::filesystem::path& path, std::size_t most = kMostTextBytes);
/// The first `most` bytes of a text file without a byte-order mark, unpacked as read_text_file()
/// does it. Of gzip that is damaged later, what comes before.
/// \throws FileError naming the path, also if it is no plain file: reading a pipe would empty it
std::string text_beginning(const std::filesystem::path& path, std::size_t most);

/// Unpacks gzip as it arrives, also of several members, in 100 kB of memory. Belongs to one thread.
class Gunzip {
 public:
  /// Gets the next bytes that came out.
  using Take = std::function<void(std::string_view)>;

  Gunzip();
  ~Gunzip();
  Gunzip(const Gunzip&) = delete;
  Gunzip& operator=(const Gunzip&) = delete;

  /// Unpacks the next bytes and passes them to `take`, at most 32 KiB at a time. An exception of
  /// take() ends the unpacking.
  /// \throws Error if the bytes are not gzip, or neither zeros nor a member follow on one
  void add(std::string_view packed, const Take& take);
  bool ended() const noexcept;  ///< whether a member has ended, and no further one has begun

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// The content of a text file, unpacked if it begins as gzip does, under any name. A plain file is
/// mapped, and must not be truncated meanwhile (mapped_file.h); others are read. Any thread may
/// read the text.
class TextFile {
 public:
  /// \throws FileError naming the path: as read_text_file()
  explicit TextFile(const std::filesystem::path& path, std::size_t most = kMostTextBytes);
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;

  /// Valid as long as *this.
  std::string_view text() const noexcept { return text_; }

 private:
  std::optional<MappedFile> mapped_;
  std::string read_;
  std::string_view text_;
};

}  // namespace enfilade
