#include "enfilade/report/detail/photographer.h"

#include <fmt/format.h>
#include <span>
#include <utility>
#include <vector>

#include "enfilade/core/base64.h"
#include "enfilade/core/errors.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/image.h"

namespace enfilade::report::detail {
namespace {

// Drawn larger and averaged: a small picture shows more of a panorama a pixel than its faces have
// texels, and would glitter.
constexpr std::uint32_t kOversampling = 3;
constexpr int kJpegQuality = 78;                 // the frames of a gallery take 10 to 20 kB each
constexpr Radians kVerticalField = degrees(60);  // what the agents see

std::string encode(const image::Image8& large, PictureSize size) {
  const std::vector<std::uint8_t> jpeg =
      image::encode_jpeg(image::shrink(large, size.width, size.height), kJpegQuality);
  const auto* bytes = reinterpret_cast<const char*>(jpeg.data());
  return data_uri("image/jpeg", {bytes, jpeg.size()});
}

render::Outputs colour_into(image::Image8& picture) {
  render::Outputs outputs;
  outputs.colour = render::ColourOutput{
      render::ColourFormat::kRgb8, {}, std::as_writable_bytes(std::span(picture.pixels))};
  return outputs;
}

}  // namespace

std::string data_uri(std::string_view type, std::string_view bytes) {
  std::string text = fmt::format("data:{};base64,", type);
  append_base64(std::as_bytes(std::span(bytes)), text);
  return text;
}

Photographer::Photographer(std::shared_ptr<const scan::PanoramaSet> panoramas)
    : panoramas_(std::move(panoramas)),
      faces_(std::make_shared<render::FaceCache>(
          panoramas_, render::FaceCacheConfig{.prefetch_thread = false})),
      renderer_(render::make_renderer(faces_)) {}

std::optional<ScanIndex> Photographer::find(std::string_view scan, ViewpointIndex viewpoint) {
  try {
    const ScanIndex index = panoramas_->at(scan);
    const scan::FaceSizes sizes = panoramas_->source(index).face_sizes(viewpoint);
    if (sizes[scan::index(scan::Layer::kColour)] > 0) return index;
  } catch (const LookupError&) {  // NOLINT(bugprone-empty-catch): names folders of this machine,
  }                               // which are nothing for a page that is handed around
  why_not_ = fmt::format("The data set has no pictures of {}.", scan);
  return std::nullopt;
}

std::optional<std::string> Photographer::view(std::string_view scan, ViewpointIndex viewpoint,
                                              Radians heading, Radians elevation,
                                              PictureSize size) {
  const auto index = find(scan, viewpoint);
  if (!index) return std::nullopt;
  image::Image8 picture(size.width * kOversampling, size.height * kOversampling, 3);
  const render::View view{*index, viewpoint, heading, elevation};
  renderer_->render({picture.width, picture.height, kVerticalField}, {&view, 1},
                    colour_into(picture));
  return encode(picture, size);
}

std::optional<std::string> Photographer::panorama(std::string_view scan, ViewpointIndex viewpoint,
                                                  Radians heading, PictureSize size) {
  const auto index = find(scan, viewpoint);
  if (!index) return std::nullopt;
  image::Image8 picture(size.width * kOversampling, size.height * kOversampling, 3);
  const render::View view{*index, viewpoint, heading, {}};
  render::render_equirectangular(faces_, view, picture.width, picture.height, colour_into(picture));
  return encode(picture, size);
}

}  // namespace enfilade::report::detail
