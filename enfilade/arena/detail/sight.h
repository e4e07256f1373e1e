/// \file  Renders the view at a session's standpoint, on graphs and in continuous environments.
#pragma once
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

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
class Sight {
 public:
  /// \throws as dataset::Dataset::faces()
  explicit Sight(Sights sights);

  /// \throws ArgumentError if there is nothing to draw it from; as render::Renderer::render(),
  /// SceneSource, continuous::Eyes::render()
  void render(const Camera& camera, const Standpoint& from, std::span<const Gaze> gazes,
              const render::Outputs& outputs);

 private:
  continuous::Eyes& eyes_in(const std::string& scan);

  Sights sights_;
  std::unique_ptr<render::Renderer> renderer_;
  std::vector<std::pair<std::string, std::unique_ptr<continuous::Eyes>>> eyes_;  // the latest last
};

}  // namespace enfilade::arena::detail
