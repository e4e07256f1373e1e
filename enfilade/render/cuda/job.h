/// \file  From a call of Renderer::render() to the kernels' input; works without a card.
#pragma once
#include <compare>
#include <cstdint>
#include <string>
#include <vector>

#include "enfilade/render/cuda/kernels.h"
#include "enfilade/render/renderer.h"

namespace enfilade::render::cuda {

/// The template arguments of Variant.
struct Kinds {
  ColourKind colour = kNoColour;
  DepthKind depth = kNoDepth;
  ClassKind classes = kNoClasses;
  bool instances = false;
  bool clamped = false;

  friend auto operator<=>(const Kinds&, const Kinds&) = default;
  /// "EN_COLOUR=1", ...: what kernels.h is compiled with.
  std::vector<std::string> definitions() const;
};

Kinds kinds_of(const Outputs& outputs, const Legacy& legacy);
/// One layer of them alone.
Kinds only(const Kinds& kinds, scan::Layer layer);
/// Layers that they draw.
scan::LayerMask layers_of(const Kinds& kinds);

/// All of a job but its views and the depth factors: size_layer is the first layer drawn. The
/// outputs' memory may be anywhere; nothing is read or written.
Job make_job(const Camera& camera, const Kinds& kinds, const Outputs& outputs);

/// The rays of a view in its panorama's frame. \pre the view is valid
Rays rays_of(const Camera& camera, const View& view, const scan::PanoramaSet& panoramas);

}  // namespace enfilade::render::cuda
