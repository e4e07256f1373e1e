/// \file  A text file, packed or not, read without a copy where that can be.
#pragma once
#include <cstddef>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

#include "enfilade/core/gzip.h"

namespace enfilade {

class MappedFile;

/// The content of a text file, unpacked if it begins as gzip does, under any name. A plain file is
/// mapped, and must not be truncated meanwhile (mapped_file.h); others are read. Any thread may
/// read the text.
class TextFile {
 public:
  /// \throws FileError naming the path: as read_text_file()
  explicit TextFile(const std::filesystem::path& path, std::size_t most = kMostTextBytes);
  ~TextFile();
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;

  /// Valid as long as *this.
  std::string_view text() const noexcept { return text_; }

 private:
  std::unique_ptr<const MappedFile> mapped_;
  std::string read_;
  std::string_view text_;
};

}  // namespace enfilade
