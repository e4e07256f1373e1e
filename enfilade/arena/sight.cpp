#include "enfilade/arena/detail/sight.h"

#include <algorithm>

#include "enfilade/core/errors.h"

namespace enfilade::arena::detail {
namespace {

constexpr std::size_t kMostScenes = 4;  // that are kept, up to 60 MB each

}  // namespace

Camera camera_for(const Standpoint& from, std::uint32_t size) {
  const bool free = std::holds_alternative<Vec3d>(from.eye);
  return {size, size, free ? degrees(90) : degrees(60)};
}

Sight::Sight(Sights sights) : sights_(std::move(sights)) {
  if (sights_.data) {
    renderer_ = render::make_renderer(sights_.data->faces(), {.threads = 1});
  }
}

continuous::Eyes& Sight::eyes_in(const std::string& scan) {
  const auto found =
      std::ranges::find_if(eyes_, [&](const auto& one) { return one.first == scan; });
  if (found != eyes_.end()) {
    std::rotate(found, found + 1, eyes_.end());
    return *eyes_.back().second;
  }
  if (!sights_.scene_of) throw ArgumentError("pictures: there are no meshes to draw them from");
  if (eyes_.size() == kMostScenes) eyes_.erase(eyes_.begin());
  eyes_.emplace_back(scan,
                     std::make_unique<continuous::Eyes>(std::vector{sights_.scene_of(scan)},
                                                        continuous::EyesConfig{.threads = 1}));
  return *eyes_.back().second;
}

void Sight::render(const Camera& camera, const Standpoint& from, std::span<const Gaze> gazes,
                   const render::Outputs& outputs) {
  if (const auto* eye = std::get_if<Vec3d>(&from.eye)) {
    std::vector<continuous::MeshView> views;
    for (const Gaze& gaze : gazes) views.push_back({0, *eye, gaze.heading, gaze.elevation});
    eyes_in(from.scan).render(camera, views, outputs);
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
