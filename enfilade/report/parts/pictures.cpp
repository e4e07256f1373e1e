#include "enfilade/report/parts/pictures.h"

#include <fmt/format.h>
#include <span>
#include <vector>

#include "enfilade/core/base64.h"
#include "enfilade/dataset/views.h"
#include "enfilade/image/codecs.h"

namespace enfilade::report::parts {
namespace {

// Drawn larger and averaged: a small picture shows more of a panorama a pixel than its faces have
// texels, and would glitter.
constexpr std::uint32_t kOversampling = 3;
constexpr int kJpegQuality = 78;                 // the frames of a gallery take 10 to 20 kB each
constexpr Radians kVerticalField = degrees(60);  // what the agents see

std::string encode(const image::Image8& large) {
  const std::vector<std::uint8_t> jpeg = image::encode_jpeg(
      image::shrink(large, large.width / kOversampling, large.height / kOversampling),
      kJpegQuality);
  return data_uri("image/jpeg", {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
}

}  // namespace

std::string data_uri(std::string_view type, std::string_view bytes) {
  std::string text = fmt::format("data:{};base64,", type);
  append_base64(std::as_bytes(std::span(bytes)), text);
  return text;
}

std::optional<std::string> view_uri(const dataset::Dataset& data, const render::View& view,
                                    PictureSize size) {
  if (!has_colour(data, view.scan, view.viewpoint)) return std::nullopt;
  return encode(render_colour(
      data, view, {size.width * kOversampling, size.height * kOversampling, kVerticalField}));
}

std::optional<std::string> panorama_uri(const dataset::Dataset& data, const render::View& view,
                                        std::uint32_t width) {
  if (!has_colour(data, view.scan, view.viewpoint)) return std::nullopt;
  return encode(render_panorama(data, view, width * kOversampling));
}

std::string no_pictures_of(std::string_view scan) {
  return fmt::format("The data set has no pictures of {}.", scan);
}

}  // namespace enfilade::report::parts
