#include "enfilade/dataset/views.h"

#include "enfilade/render/renderer.h"

namespace enfilade::dataset {
namespace {

render::Pictures draw(const Dataset& dataset, const render::View& view, const Camera& camera,
                      scan::Layer layer) {
  render::Pictures pictures;
  render::make_renderer(dataset.faces())
      ->render(camera, {&view, 1},
               outputs_into(pictures, scan::mask_of(layer), camera.width, camera.height));
  return pictures;
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
  return draw(dataset, view, camera, scan::Layer::kColour).colour;
}

image::Image8 render_colour(const Dataset& dataset, const NamedView& view, const Camera& camera) {
  return render_colour(dataset, find_view(dataset, view), camera);
}

image::Image16 render_depth(const Dataset& dataset, const render::View& view,
                            const Camera& camera) {
  return draw(dataset, view, camera, scan::Layer::kDepth).depth;
}

image::Image16 render_depth(const Dataset& dataset, const NamedView& view, const Camera& camera) {
  return render_depth(dataset, find_view(dataset, view), camera);
}

image::Image32 render_instances(const Dataset& dataset, const render::View& view,
                                const Camera& camera) {
  return draw(dataset, view, camera, scan::Layer::kInstance).instances;
}

image::Image8 render_panorama(const Dataset& dataset, const render::View& view,
                              std::uint32_t width) {
  render::Pictures pictures;
  render::render_equirectangular(
      dataset.faces(), view, width, width / 2,
      outputs_into(pictures, scan::mask_of(scan::Layer::kColour), width, width / 2));
  return pictures.colour;
}

image::Image8 render_panorama(const Dataset& dataset, const NamedView& view, std::uint32_t width) {
  return render_panorama(dataset, find_view(dataset, view), width);
}

}  // namespace enfilade::dataset
