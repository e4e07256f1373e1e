#include "enfilade/arena/detail/view_renderer.h"

#include <vector>

#include "enfilade/core/errors.h"

namespace enfilade::arena::detail {
namespace {

constexpr std::size_t kMostScenes = 4;  // that are kept

}  // namespace

Camera camera_for(const Standpoint& from, std::uint32_t size) {
  const bool free = std::holds_alternative<Vec3d>(from.eye);
  return {size, size, free ? degrees(90) : degrees(60)};
}

ViewRenderer::ViewRenderer(const ViewSources& sights) {
  if (sights.data) renderer_ = render::make_renderer(sights.data->faces(), {.threads = 1});
  if (sights.scene_of) scenes_.emplace(sights.scene_of, 1, kMostScenes);
}

void ViewRenderer::render(const Camera& camera, const Standpoint& from, std::span<const Gaze> gazes,
                          const render::Outputs& outputs) {
  if (const auto* eye = std::get_if<Vec3d>(&from.eye)) {
    std::vector<continuous::MeshView> views;
    for (const Gaze& gaze : gazes) views.push_back({0, *eye, gaze.heading, gaze.elevation});
    if (!scenes_) throw ArgumentError("pictures: there are no meshes to draw them from");
    scenes_->of(from.scan).render(camera, views, outputs);
    return;
  }
  if (!renderer_) throw ArgumentError("pictures: there are no panoramas to draw them from");
  const auto location = std::get<graph::Location>(from.eye);
  std::vector<render::View> views;
  for (const Gaze& gaze : gazes) {
    views.push_back({location.scan, location.viewpoint, gaze.heading, gaze.elevation});
  }
  renderer_->render(camera, views, outputs);
}

}  // namespace enfilade::arena::detail
