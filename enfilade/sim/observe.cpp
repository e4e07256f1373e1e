#include "enfilade/sim/observe.h"

#include <fmt/format.h>

#include <algorithm>

#include "enfilade/core/errors.h"

namespace enfilade::sim {
namespace {

// Faces of one viewpoint that would be seen with an agent's heading and elevation.
void add_faces(const render::View& view, const Camera& camera, std::span<const scan::Layer> layers,
               const scan::PanoramaSource& source, std::vector<render::FaceKey>& keys) {
  const Mat3d panorama_from_camera =
      transpose(source.poses()[view.viewpoint.at()].world_from_panorama) *
      world_from_camera(view.heading, view.elevation);
  const scan::FaceMask mask = faces_in_view(camera, panorama_from_camera);
  for (const scan::Layer layer : layers) {
    for (std::size_t k = 0; k < kCubeFaces; ++k) {
      if ((mask >> k & 1U) != 0) keys.push_back({view.scan, view.viewpoint, layer, cube_face(k)});
    }
  }
}

}  // namespace

void views_of(const StateSpans& state, std::span<render::View> views) {
  if (views.size() != state.scan.size()) {
    throw ArgumentError(
        fmt::format("views: {}, but the state has {} agents", views.size(), state.scan.size()));
  }
  for (std::size_t k = 0; k < views.size(); ++k) {
    views[k] = {state.scan[k], state.viewpoint[k], Radians(state.heading[k]),
                Radians(state.elevation[k])};
  }
}

void prefetch_neighbours(const StateSpans& state, std::size_t max_navigable, const Camera& camera,
                         std::span<const scan::Layer> layers, render::FaceCache& faces,
                         std::size_t neighbours) {
  validate(camera);
  std::vector<render::FaceKey> keys;
  for (std::size_t k = 0; k < state.scan.size(); ++k) {
    const scan::PanoramaSource& source = faces.panoramas().source(state.scan[k]);
    // Place 0 is where the agent stands.
    const std::size_t last = std::min<std::size_t>(state.navigable_count[k], neighbours + 1);
    for (std::size_t n = 1; n < last; ++n) {
      const render::View view{state.scan[k], state.navigable_viewpoint[k * max_navigable + n],
                              Radians(state.heading[k]), Radians(state.elevation[k])};
      add_faces(view, camera, layers, source, keys);
    }
  }
  faces.prefetch(keys);
}

}  // namespace enfilade::sim
