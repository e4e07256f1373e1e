#include "enfilade/dataset/views.h"

#include <cstddef>
#include <span>

namespace enfilade::dataset {
namespace {

template <class T>
std::span<std::byte> bytes_of(image::Image<T>& picture) {
  return std::as_writable_bytes(std::span(picture.pixels));
}

render::Outputs colour_into(image::Image8& picture) {
  render::Outputs outputs;
  outputs.colour = render::ColourOutput{render::ColourFormat::kRgb8, {}, bytes_of(picture)};
  return outputs;
}

void draw(const Dataset& dataset, const render::View& view, const Camera& camera,
          const render::Outputs& outputs) {
  render::make_renderer(dataset.faces())->render(camera, {&view, 1}, outputs);
}

}  // namespace

render::View find_view(const Dataset& dataset, const NamedView& view) {
  const graph::Location at = dataset.graphs()->locate(view.scan, view.viewpoint);
  return {at.scan, at.viewpoint, view.heading, view.elevation};
}

bool has_colour(const Dataset& dataset, ScanIndex scan, ViewpointIndex viewpoint) {
  const scan::PanoramaSource* source = dataset.panoramas()->find_source(scan);
  return source != nullptr && source->face_sizes(viewpoint)[scan::index(scan::Layer::kColour)] > 0;
}

image::Image8 render_colour(const Dataset& dataset, const render::View& view,
                            const Camera& camera) {
  image::Image8 picture(camera.width, camera.height, 3);
  draw(dataset, view, camera, colour_into(picture));
  return picture;
}

image::Image8 render_colour(const Dataset& dataset, const NamedView& view, const Camera& camera) {
  return render_colour(dataset, find_view(dataset, view), camera);
}

image::Image16 render_depth(const Dataset& dataset, const render::View& view,
                            const Camera& camera) {
  image::Image16 picture(camera.width, camera.height, 1);
  render::Outputs outputs;
  outputs.depth = render::DepthOutput{render::DepthFormat::kQuarterMillimetresUint16,
                                      render::DepthMeasure::kZ, bytes_of(picture)};
  draw(dataset, view, camera, outputs);
  return picture;
}

image::Image16 render_depth(const Dataset& dataset, const NamedView& view, const Camera& camera) {
  return render_depth(dataset, find_view(dataset, view), camera);
}

image::Image32 render_instances(const Dataset& dataset, const render::View& view,
                                const Camera& camera) {
  image::Image32 picture(camera.width, camera.height, 1);
  render::Outputs outputs;
  outputs.instances = render::InstanceOutput{picture.pixels};
  draw(dataset, view, camera, outputs);
  return picture;
}

image::Image8 render_panorama(const Dataset& dataset, const render::View& view,
                              std::uint32_t width) {
  image::Image8 picture(width, width / 2, 3);
  render::render_equirectangular(dataset.faces(), view, picture.width, picture.height,
                                 colour_into(picture));
  return picture;
}

image::Image8 render_panorama(const Dataset& dataset, const NamedView& view, std::uint32_t width) {
  return render_panorama(dataset, find_view(dataset, view), width);
}

}  // namespace enfilade::dataset
