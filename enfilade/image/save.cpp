#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"

namespace enfilade::image {

void save(const std::string& path, const Image8& picture, int jpeg_quality) {
  const std::size_t dot = path.rfind('.');
  const std::string suffix = dot == std::string::npos ? "" : path.substr(dot);
  std::vector<std::uint8_t> bytes;
  if (suffix == ".png") {
    bytes = encode_png(picture);
  } else if (suffix == ".jpg" || suffix == ".jpeg") {
    bytes = encode_jpeg(picture, jpeg_quality, jpeg_quality >= kFullChromaQuality);
  } else {
    throw ArgumentError(path + ": a name that ends in .png, .jpg or .jpeg is expected");
  }
  write_file_atomically(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace enfilade::image
