/// \file  Arithmetic with directions and colours.
#pragma once
#include <algorithm>
#include <cmath>

#include "enfilade/geometry/vec.h"

namespace enfilade::mesh {

inline Vec3f operator*(float k, Vec3f v) { return {k * v.x, k * v.y, k * v.z}; }
/// Part by part: light on a colour.
inline Vec3f operator*(Vec3f a, Vec3f b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline Vec3f& operator+=(Vec3f& a, Vec3f b) { return a = a + b; }
inline Vec3f operator-(Vec3f v) { return {-v.x, -v.y, -v.z}; }
inline float dot(Vec3f a, Vec3f b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vec3f cross(Vec3f a, Vec3f b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
/// Of length 1; `otherwise` for a vector too short to have a direction.
inline Vec3f unit(Vec3f v, Vec3f otherwise = {0, 0, 1}) {
  const float size = length(v);
  return size > 1e-20F ? (1 / size) * v : otherwise;
}
inline Vec3f mix(Vec3f a, Vec3f b, float t) { return (1 - t) * a + t * b; }
inline Vec3f to_float(Vec3d v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
/// ITU-R BT.709.
inline float luminance(Vec3f c) { return 0.2126F * c.x + 0.7152F * c.y + 0.0722F * c.z; }

}  // namespace enfilade::mesh
