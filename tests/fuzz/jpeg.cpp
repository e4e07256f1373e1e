// Any bytes are a picture or refused; so are the faces of what could be a strip.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/image/codecs.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace enfilade;
  constexpr std::uint64_t kMostPixels = 1U << 18U;  // larger ones are only slower
  const image::Bytes bytes(data, size);
  try {
    const image::Shape shape = image::jpeg_shape(bytes, "<fuzz>");
    if (std::uint64_t{shape.width} * shape.height > kMostPixels) return 0;
    if (const auto faces = image::cut_jpeg_strip(bytes, "<fuzz>")) {
      for (const auto& face : *faces) {
        const image::Image8 picture = image::decode_jpeg(face, "<face>");
        EN_CHECK_EQ(picture.width, shape.height);
        EN_CHECK_EQ(picture.height, shape.height);
      }
    }
    const image::Image8 picture = image::decode_jpeg(bytes, "<fuzz>");
    std::vector<std::uint8_t> pixels(picture.pixels.size());
    image::decode_jpeg(bytes, shape.width, shape.height, pixels, "<fuzz>");
    EN_CHECK(pixels == picture.pixels);
  } catch (const InvalidInput&) {
  }
  return 0;
}
