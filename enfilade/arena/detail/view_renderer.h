/// \file  Renders the view at a session's standpoint, on graphs and in continuous environments.
#pragma once
#include <memory>
#include <optional>
#include <span>

#include "enfilade/arena/pictures.h"
#include "enfilade/continuous/eyes.h"
#include "enfilade/geometry/camera.h"
#include "enfilade/render/renderer.h"

namespace enfilade::arena::detail {

/// A direction of view.
struct Gaze {
  Radians heading, elevation;
};

/// The camera of a single view: 60 degrees on graphs, 90 in continuous space.
Camera camera_for(const Standpoint& from, std::uint32_t size);

/// Keeps a renderer, or the mesh renderers of the buildings used last. One thread at a time.
class ViewRenderer {
 public:
  /// \throws as dataset::Dataset::faces()
  explicit ViewRenderer(const ViewSources& sights);

  /// \throws ArgumentError if there is nothing to draw it from; as render::Renderer::render(),
  /// continuous::EyesCache::of(), Eyes::render()
  void render(const Camera& camera, const Standpoint& from, std::span<const Gaze> gazes,
              const render::Outputs& outputs);

 private:
  std::unique_ptr<render::Renderer> renderer_;   // null: there are no panoramas
  std::optional<continuous::EyesCache> scenes_;  // no value: there are no meshes
};

}  // namespace enfilade::arena::detail
