/// \file  Colours of a tile's pixels with vector instructions: of surfaces, and of panoramas.
#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <vector>

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
  bool longer_step;  ///< textures are averaged over PixelPainter::longer_step()
};

/// Writes kTilePixels colours, RGBA, equal to PixelPainter::look() to the bit. Mirrors and the sky
/// are left out. \returns the pixels that are left out, as bits
using Shader = std::uint64_t (*)(const TileColours& tile, std::uint32_t* rgba);
/// With the processor's best vector instructions.
Shader best_shader();
/// By the names and in the order of rasteriser_variants().
const std::vector<Shader>& shader_variants();

/// Six faces with a border of a texel, in halved sizes; and how near the mesh is at each texel of
/// the largest size.
struct Photo {
  static constexpr std::uint32_t kMostLevels = 8;

  Vec3f centre;                ///< world
  Vec3f right, down, forward;  ///< the panorama's axes in the world
  std::uint32_t size = 0;      ///< texels along an edge
  std::uint32_t levels = 0;    ///< sizes: size, size / 2, ...
  /// By level: where its faces begin in `colours`.
  std::array<std::int32_t, kMostLevels> first{};
  std::vector<std::uint32_t> colours;  ///< RGBA, R lowest
  std::vector<float> nearness;         ///< 1 / distance along the face's axis

  std::uint32_t size_of(std::uint32_t level) const { return size >> level; }
};

/// Texels of a face with its border.
constexpr std::size_t bordered_texels(std::uint32_t size) {
  return (std::size_t{size} + 2) * (size + 2);
}

/// Weights of panoramas. All lengths in metres.
///
/// The angle between the lines from the eye and from the panorama has most weight, as surfaces
/// shine and meshes are not exact. The panorama's coarseness at the point comes next.
inline constexpr float kCoarseness = 0.05F;  ///< penalty for each time farther than the eye is
inline constexpr float kLeastPenalty = 2e-3F;
/// A panorama sees a point if its nearness there is the mesh's within this part, and this much.
inline constexpr float kSamePart = 0.015F, kSameNearness = 2e-4F;
/// Metres; points nearer to the panorama get no direction.
inline constexpr float kLeastAlong = 1e-6F;
/// Where the sky is taken to be.
inline constexpr float kSkyDistance = 1e4F;

/// Computes colours of a tile from panoramas, blended; alpha is not used. Returns the pixels that
/// no panorama sees, or that show a mirror, as bits. Their colours are not written.
using Reprojector = std::uint64_t (*)(const TileColours& tile, std::span<const Photo* const> photos,
                                      std::uint32_t* rgba);
/// With the processor's best vector instructions.
Reprojector best_reprojector();
/// By the names and in the order of rasteriser_variants().
const std::vector<Reprojector>& reprojector_variants();
/// One pixel after another: the reference for the others.
std::uint64_t reproject_plainly(const TileColours& tile, std::span<const Photo* const> photos,
                                std::uint32_t* rgba);

}  // namespace enfilade::continuous::pixels
