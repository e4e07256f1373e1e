#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"

namespace enfilade::image {

namespace {

// Grey becomes three equal channels, an alpha channel is dropped.
Image8 to_rgb(Image8 picture) {
  if (picture.channels == 3) return picture;
  Image8 rgb(picture.width, picture.height, 3);
  const std::size_t step = picture.channels < 3 ? 0 : 1;
  const std::uint8_t* from = picture.pixels.data();
  for (std::size_t i = 0; i < rgb.pixels.size(); i += 3, from += picture.channels) {
    for (std::size_t c = 0; c < 3; ++c) rgb.pixels[i + c] = from[c * step];
  }
  return rgb;
}

}  // namespace

Image8 load_picture(const std::string& path, std::optional<double> exposure) {
  const std::string content = read_file(path);
  const std::string_view text = content;
  const Bytes bytes = bytes_of(text);
  if (text.starts_with("\xff\xd8")) return decode_jpeg(bytes, path);
  if (text.starts_with("\x89PNG")) return to_rgb(decode_png8(bytes, path));
  if (text.starts_with("#?")) return tone_map(decode_hdr(bytes, path), exposure);
  refuse(path, "", "unknown-picture",
         text.empty() ? "the file is empty" : "neither JPEG, nor PNG, nor Radiance HDR");
}

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
