#include "enfilade/image/detail/photo_notes.h"

#include <cstdint>
#include <string_view>

namespace enfilade::image::detail {
namespace {

constexpr std::string_view kExif{"Exif\0\0", 6}, kXmp{"http://ns.adobe.com/xap/1.0/\0", 29};

std::string_view text_of(Bytes bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

// Numbers of TIFF, in either order of bytes. What lies outside is 0.
class Tiff {
 public:
  explicit Tiff(Bytes bytes)
      : bytes_(bytes), little_(text_of(bytes).starts_with(std::string_view("II*\0", 4))) {}
  bool is_valid() const {
    return little_ || text_of(bytes_).starts_with(std::string_view("MM\0*", 4));
  }
  std::uint32_t number(std::size_t at, std::size_t size) const {
    if (at > bytes_.size() || bytes_.size() - at < size) return 0;
    std::uint32_t value = 0;
    for (std::size_t k = 0; k < size; ++k) {
      value = value << 8U | bytes_[at + (little_ ? size - 1 - k : k)];
    }
    return value;
  }

 private:
  Bytes bytes_;
  bool little_;
};

}  // namespace

void read_exif(Bytes bytes, PhotoNotes& notes) {
  if (text_of(bytes).starts_with(kExif)) bytes = bytes.subspan(kExif.size());
  const Tiff tiff(bytes);
  if (!tiff.is_valid()) return;
  constexpr std::uint32_t kOrientation = 0x0112, kShort = 3;
  const std::size_t directory = tiff.number(4, 4);
  const std::size_t entries = tiff.number(directory, 2);
  for (std::size_t k = 0; k < entries; ++k) {
    const std::size_t at = directory + 2 + 12 * k;
    if (tiff.number(at, 2) != kOrientation || tiff.number(at + 2, 2) != kShort) continue;
    const std::uint32_t value = tiff.number(at + 8, 2);
    if (value >= 1 && value <= 8) notes.orientation = static_cast<int>(value);
    return;
  }
}

PhotoNotes jpeg_notes(Bytes jpeg) {
  constexpr std::uint8_t kApp1 = 0xE1, kStartOfScan = 0xDA, kFill = 0xFF;
  PhotoNotes notes;
  std::size_t at = 2;
  while (at + 4 <= jpeg.size() && jpeg[at] == 0xFF) {
    const std::uint8_t marker = jpeg[at + 1];
    if (marker == kFill) {  // bytes that fill up
      ++at;
      continue;
    }
    const std::size_t size = std::size_t{jpeg[at + 2]} << 8U | jpeg[at + 3];
    if (marker == kStartOfScan || size < 2 || at + 2 + size > jpeg.size()) break;
    const std::string_view body = text_of(jpeg.subspan(at + 4, size - 2));
    if (marker == kApp1 && body.starts_with(kExif)) {
      read_exif(bytes_of(body), notes);
    } else if (marker == kApp1 && body.starts_with(kXmp)) {
      notes.xmp = body.substr(kXmp.size());
    }
    at += 2 + size;
  }
  return notes;
}

}  // namespace enfilade::image::detail
