/// \file  Arithmetic with directions and colours.
#pragma once
#include <numbers>

#include "enfilade/geometry/vec.h"
#include "enfilade/image/tone.h"

namespace enfilade::mesh::detail {

inline constexpr float kFloatPi = std::numbers::pi_v<float>;

/// Componentwise product.
inline Vec3f operator*(Vec3f a, Vec3f b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
/// The vector scaled to length 1; `otherwise` if its length is about 0.
inline Vec3f unit(Vec3f v, Vec3f otherwise = {0, 0, 1}) {
  const float size = length(v);
  return size > 1e-20F ? (1 / size) * v : otherwise;
}
/// Computed in double precision; `otherwise` if the length is 0 or not a number.
inline Vec3f unit(Vec3d v, Vec3f otherwise) {
  const double size = length(v);
  return size > 0 ? to_float({v.x / size, v.y / size, v.z / size}) : otherwise;
}
inline Vec3f mix(Vec3f a, Vec3f b, float t) { return (1 - t) * a + t * b; }
inline float luminance(Vec3f c) { return image::luminance(c.x, c.y, c.z); }

}  // namespace enfilade::mesh::detail
