// Any bytes are a picture or refused; so are the faces of what could be a strip. With restart
// markers the picture is the same.
#include <cstddef>
#include <cstdint>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/face_cells.h"
#include "enfilade/image/jpeg_rows.h"
#include "enfilade/image/photo.h"

namespace {

using namespace enfilade;

// Whatever the bytes are, reading rows stays within its memory.
void read_rows(image::Bytes bytes, std::uint32_t size) {
  if (size > 512) return;  // a wide one would want a square of memory
  std::vector<std::uint8_t> cells(image::ColourCells::bytes(size));
  image::decode_rows(bytes, {0, size}, {cells.data(), size});
  image::decode_rows(bytes, {size / 3, size / 3 + 1}, {cells.data(), size});
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  constexpr std::uint64_t kMostPixels = 1U << 18U;  // larger ones are only slower
  const image::Bytes bytes(data, size);
  try {
    const image::Shape shape = image::jpeg_shape(bytes, "<fuzz>");
    if (std::uint64_t{shape.width} * shape.height > kMostPixels) return 0;
    read_rows(bytes, shape.width);
    if (const auto faces = image::cut_jpeg_strip(bytes, "<fuzz>")) {
      for (const auto& face : *faces) {
        const image::Image8 picture = image::decode_jpeg(face, "<face>");
        EN_CHECK_EQ(picture.width, shape.height);
        EN_CHECK_EQ(picture.height, shape.height);
      }
    }
    const image::Image8 picture = image::decode_jpeg(bytes, "<fuzz>");
    const image::Photo photo = image::decode_photo(bytes, "<fuzz>");
    EN_CHECK_EQ(photo.picture.pixels.size(), picture.pixels.size());
    std::vector<std::uint8_t> pixels(picture.pixels.size());
    image::decode_jpeg(bytes, shape.width, shape.height, pixels, "<fuzz>");
    EN_CHECK(pixels == picture.pixels);
    if (const auto marked = image::mark_rows(bytes, "<fuzz>")) {
      EN_CHECK(image::decode_jpeg(*marked, "<marked>").pixels == picture.pixels);
      read_rows(*marked, shape.width);
    }
  } catch (const InvalidInput&) {
  }
  return 0;
}
