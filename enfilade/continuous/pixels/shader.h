/// \file  Colours of a tile's pixels with vector instructions. They equal Painter::look() to the
/// bit; mirrors and the sky are left to it.
#pragma once
#include <cstdint>

#include "enfilade/continuous/pixels/frame.h"
#include "enfilade/continuous/pixels/scene_parts.h"

namespace enfilade::continuous::pixels {

/// Directions of a tile's pixels in the world.
struct Directions {
  alignas(64) std::array<float, kTilePixels> x, y, z;
};

/// A tile to paint.
struct TileColours {
  const SceneParts& scene;
  const Eye& eye;
  float spread;                  ///< angle between pixels
  const std::int32_t* triangle;  ///< of kTilePixels pixels
  const float* nearness;
  const Directions& towards;
};

/// Writes kTilePixels colours, RGBA. \returns the pixels that are left out, as bits
using Shader = std::uint64_t (*)(const TileColours& tile, std::uint32_t* rgba);
/// With the processor's best vector instructions.
Shader best_shader();
/// By the names and in the order of rasteriser_variants().
const std::vector<Shader>& shader_variants();

}  // namespace enfilade::continuous::pixels
