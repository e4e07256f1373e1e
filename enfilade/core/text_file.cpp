#include "enfilade/core/text_file.h"

#include <system_error>

#include "enfilade/core/mapped_file.h"

namespace enfilade {

TextFile::TextFile(const std::filesystem::path& path, std::size_t most) {
  // What is small is read at once: mapping costs more. So are pipes, which have no size.
  constexpr std::uintmax_t kLeastMapped = std::uintmax_t{1} << 20U;
  std::error_code code;
  if (std::filesystem::is_regular_file(path, code) &&
      std::filesystem::file_size(path, code) >= kLeastMapped) {
    mapped_ = std::make_unique<MappedFile>(path);
    const auto bytes = mapped_->bytes();
    text_ = {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
    if (!text_.starts_with("\x1f\x8b")) return;
    mapped_.reset();
  }
  read_ = read_text_file(path, most);
  text_ = read_;
}

TextFile::~TextFile() = default;

}  // namespace enfilade
