// Any bytes are a picture or refused; what is read, written and read again is equal. Checksums are
// set right first: by chance they never are, and nothing behind them would be reached.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/photo.h"

namespace {

// PNG's CRC (W3C, annex D), bit by bit.
std::uint32_t checksum(const std::uint8_t* data, std::size_t size) {
  std::uint32_t crc = ~0U;
  for (std::size_t i = 0; i < size; ++i) {
    crc ^= data[i];
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1U) != 0 ? crc >> 1U ^ 0xedb88320U : crc >> 1U;
  }
  return ~crc;
}

void mend_checksums(std::vector<std::uint8_t>& png) {
  constexpr std::size_t kSignature = 8, kLengthAndName = 8, kChecksum = 4;
  for (std::size_t at = kSignature; at + kLengthAndName + kChecksum <= png.size();) {
    std::size_t length = 0;
    for (std::size_t k = 0; k < 4; ++k) length = length << 8U | png[at + k];
    const std::size_t end = at + kLengthAndName + length;
    if (end + kChecksum > png.size()) return;
    const std::uint32_t crc = checksum(png.data() + at + 4, length + 4);
    for (std::size_t k = 0; k < 4; ++k) {
      png[end + k] = static_cast<std::uint8_t>(crc >> (24 - 8 * k));
    }
    at = end + kChecksum;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  constexpr std::uint64_t kMostPixels = 1U << 20U;  // larger ones are only slower
  std::vector<std::uint8_t> mended(data, data + size);
  mend_checksums(mended);
  const image::Bytes bytes(mended);
  try {
    const image::Shape shape = image::png_shape(bytes, "<fuzz>");
    if (std::uint64_t{shape.width} * shape.height > kMostPixels) return 0;
    EN_CHECK_EQ(image::decode_photo(bytes, "<fuzz>").picture.channels, shape.channels);
    if (shape.bits == 16) {
      const image::Image16 picture = image::decode_png16(bytes, "<fuzz>");
      EN_CHECK(image::decode_png16(image::encode_png(picture), "<written>") == picture);
    } else {
      const image::Image8 picture = image::decode_png8(bytes, "<fuzz>");
      EN_CHECK_EQ(picture.channels, shape.channels);
      EN_CHECK(image::decode_png8(image::encode_png(picture), "<written>") == picture);
      image::decode_png16(bytes, "<fuzz>");
    }
  } catch (const InvalidInput&) {
  }
  return 0;
}
