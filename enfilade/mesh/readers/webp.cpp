#include "enfilade/mesh/readers/webp.h"

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"

#ifdef EN_WITH_WEBP
#include <webp/decode.h>
#endif

namespace enfilade::mesh::readers {

bool is_webp(std::string_view bytes) {
  return bytes.size() >= 12 && bytes.starts_with("RIFF") && bytes.substr(8, 4) == "WEBP";
}

std::string_view webp_exif(std::string_view bytes) {
  constexpr std::size_t kHead = 8;  // of a chunk: four letters, and its size
  std::size_t at = 12;
  while (at < bytes.size() && bytes.size() - at >= kHead) {
    std::size_t size = 0;
    for (std::size_t k = kHead; k-- > 4;) {
      size = size << 8U | static_cast<std::uint8_t>(bytes[at + k]);
    }
    if (bytes.substr(at, 4) == "EXIF") return bytes.substr(at + kHead, size);
    at += kHead + size + size % 2;
  }
  return {};
}

#ifdef EN_WITH_WEBP

namespace {

const std::uint8_t* raw(std::string_view bytes) {
  return reinterpret_cast<const std::uint8_t*>(bytes.data());
}

WebPBitstreamFeatures features_of(std::string_view bytes, const std::string& file) {
  WebPBitstreamFeatures out;
  if (WebPGetFeatures(raw(bytes), bytes.size(), &out) != VP8_STATUS_OK || out.width <= 0 ||
      out.height <= 0) {
    refuse(file, "", "bad-picture", "not a WebP picture, or a damaged one");
  }
  if (out.has_animation != 0) refuse(file, "", "bad-picture", "a WebP animation, not a picture");
  return out;
}

}  // namespace

bool reads_webp() noexcept { return true; }

image::Shape webp_shape(std::string_view bytes, const std::string& file) {
  const WebPBitstreamFeatures found = features_of(bytes, file);
  return {static_cast<std::uint32_t>(found.width), static_cast<std::uint32_t>(found.height),
          found.has_alpha != 0 ? 4U : 3U};
}

image::Image8 decode_webp(std::string_view bytes, const std::string& file, std::uint64_t most) {
  const image::Shape shape = webp_shape(bytes, file);
  const unsigned halvings = image::halvings_to(shape.width, shape.height, most);
  constexpr int kLossy = 1;  // WebPBitstreamFeatures::format
  if (halvings > 0 && features_of(bytes, file).format != kLossy) {
    image::refuse_whole("a lossless WebP picture", shape.width, shape.height, most, file);
  }
  image::Image8 out(image::halved(shape.width, halvings), image::halved(shape.height, halvings),
                    shape.channels);
  WebPDecoderConfig config;
  EN_CHECK(WebPInitDecoderConfig(&config) != 0);
  config.options.use_scaling = halvings > 0 ? 1 : 0;
  config.options.scaled_width = static_cast<int>(out.width);
  config.options.scaled_height = static_cast<int>(out.height);
  config.output.colorspace = shape.channels == 4 ? MODE_RGBA : MODE_RGB;
  config.output.is_external_memory = 1;
  config.output.u.RGBA = {out.pixels.data(), static_cast<int>(out.width * out.channels),
                          out.pixels.size()};
  if (WebPDecode(raw(bytes), bytes.size(), &config) != VP8_STATUS_OK) {
    refuse(file, "", "bad-picture", "a damaged WebP picture");
  }
  return out;
}

#else

bool reads_webp() noexcept { return false; }

image::Shape webp_shape(std::string_view, const std::string& file) {
  refuse(file, "", "unknown-picture",
         "a WebP picture, and this build is without libwebp (libwebp-dev)");
}

image::Image8 decode_webp(std::string_view bytes, const std::string& file, std::uint64_t) {
  webp_shape(bytes, file);
  return {};
}

#endif

}  // namespace enfilade::mesh::readers
