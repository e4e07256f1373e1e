/// \file  Data of each triangle for rendering: its position, its texture, its light.
#pragma once
#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include "enfilade/continuous/pixels/textures.h"
#include "enfilade/continuous/pixels/tone.h"
#include "enfilade/mesh/mesh.h"

namespace enfilade::continuous::pixels {

/// Least sine of the angle between a line of sight and a surface, for the size of a pixel's
/// footprint there.
inline constexpr float kLeastSlant = 0.05F;

/// A triangle. Its corners are numbered from the one opposite the longest edge on. So the two edges
/// that meet there are the legs of a grid that wastes little.
struct alignas(64) Surface {
  Vec3f origin;            ///< corner 0
  Vec3f along_u, along_v;  ///< a point's weight of corner 1 is dot(along_u, point - origin)
  Vec3f normal;            ///< length 1, on the front
  float s0 = 0, t0 = 0, su = 0, tu = 0, sv = 0, tv = 0;  ///< texture point: s0 + u su + v sv
  float texels_per_metre = 0;
  std::uint32_t paint = 0;                 ///< in Surfaces::paints
  std::uint32_t front = 0, back = 0;       ///< first value of its light on either side
  std::uint16_t cells_u = 0, cells_v = 0;  ///< light is in (cells_u + 1) (cells_v + 1) values
  std::uint16_t category = 0;
  std::uint8_t first_corner = 0;  ///< of the mesh's triangle
  std::uint32_t instance = 0;
};

/// A material.
struct Paint {
  static constexpr std::uint32_t kNoTexture = 0xFFFFFFFFU;
  Vec3f colour;     ///< without the share that is reflected as by a mirror
  float gloss = 0;  ///< added for such a reflection, if it is small
  Vec3f emission;
  float mirror = 0;  ///< reflected so
  float cutout = 0;  ///< 0: none
  std::uint32_t texture = kNoTexture;
};

/// Weights of corners 1 and 2.
struct Weights {
  float u, v;
};
/// In [0, 1]; 0 for NaN.
inline float share(float weight) { return weight > 0 ? std::min(weight, 1.0F) : 0; }
/// \param from from the surface's origin
inline Weights weights_at(const Surface& surface, Vec3f from) {
  return {share(dot(surface.along_u, from)), share(dot(surface.along_v, from))};
}

/// All triangles of a mesh.
class Surfaces {
 public:
  /// Light 1 on both sides, times the mesh's colours. \pre mesh passes check()
  /// \param least_mirror  less is gloss
  Surfaces(const mesh::Mesh& mesh, float least_mirror);

  /// One of kDark and kWhite is at these places of `light`.
  static constexpr std::uint32_t kDark = 0, kWhite = 1;

  std::vector<Surface> all;  ///< by triangle
  std::vector<Paint> paints;
  Textures textures;
  std::vector<std::uint32_t> light;  ///< pack_light(), times the mesh's colours

  /// Whether there is a surface at this point of a triangle, whose texture may have holes.
  bool is_there(std::uint32_t triangle, Weights at) const {
    const Surface& s = all[triangle];
    const Paint& paint = paints[s.paint];
    return paint.cutout <= 0 || textures.alpha(paint.texture, s.s0 + at.u * s.su + at.v * s.sv,
                                               s.t0 + at.u * s.tu + at.v * s.tv) >= paint.cutout;
  }
  bool has_holes(std::uint32_t triangle) const { return paints[all[triangle].paint].cutout > 0; }
};

/// The light on one side of a surface, bilinear. \param first of its values
inline Vec3f light_at(const std::uint32_t* light, const Surface& surface, std::uint32_t first,
                      Weights at) {
  light += first;
  if (first <= Surfaces::kWhite) return unpack_light(*light);
  const float x = at.u * static_cast<float>(surface.cells_u);
  const float y = at.v * static_cast<float>(surface.cells_v);
  const std::uint32_t i = std::min<std::uint32_t>(static_cast<std::uint32_t>(x),
                                                  surface.cells_u == 0 ? 0 : surface.cells_u - 1U);
  const std::uint32_t j = std::min<std::uint32_t>(static_cast<std::uint32_t>(y),
                                                  surface.cells_v == 0 ? 0 : surface.cells_v - 1U);
  const float a = x - static_cast<float>(i), b = y - static_cast<float>(j);
  const std::uint32_t pitch = surface.cells_u + 1U;
  const std::uint32_t* const low = light + std::size_t{j} * pitch + i;
  const std::uint32_t* const high = low + (surface.cells_v == 0 ? 0 : pitch);
  const std::uint32_t next = surface.cells_u == 0 ? 0 : 1;
  return (1 - b) * ((1 - a) * unpack_light(low[0]) + a * unpack_light(low[next])) +
         b * ((1 - a) * unpack_light(high[0]) + a * unpack_light(high[next]));
}

}  // namespace enfilade::continuous::pixels
