/// \file  Rotations between frames.
#pragma once
#include <array>
#include <cstddef>

#include "enfilade/geometry/vec.h"

namespace enfilade {

/// 3 x 3, row-major. Named by what it maps: `world_from_panorama * v` takes v from the panorama's
/// frame to the world's. A plain value.
struct Mat3d {
  std::array<double, 9> m{1, 0, 0, 0, 1, 0, 0, 0, 1};

  friend constexpr bool operator==(const Mat3d&, const Mat3d&) = default;
  friend constexpr Vec3d operator*(const Mat3d& a, Vec3d v) {
    return {a.m[0] * v.x + a.m[1] * v.y + a.m[2] * v.z, a.m[3] * v.x + a.m[4] * v.y + a.m[5] * v.z,
            a.m[6] * v.x + a.m[7] * v.y + a.m[8] * v.z};
  }
  friend constexpr Mat3d operator*(const Mat3d& a, const Mat3d& b) {
    Mat3d c;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) {
        c.m[3 * i + j] =
            a.m[3 * i] * b.m[j] + a.m[3 * i + 1] * b.m[3 + j] + a.m[3 * i + 2] * b.m[6 + j];
      }
    }
    return c;
  }
};

/// The inverse of a rotation.
constexpr Mat3d transpose(const Mat3d& a) {
  return {{a.m[0], a.m[3], a.m[6], a.m[1], a.m[4], a.m[7], a.m[2], a.m[5], a.m[8]}};
}

/// Largest deviation of R^T R from the identity in what counts as a rotation. Six digits, as poses'
/// files hold them, leave errors of 1e-6 in the products; a scale or a sheared frame shows far
/// above this.
inline constexpr double kRotationTolerance = 1e-3;

/// Orthonormal to kRotationTolerance, and right-handed. False where a number is not finite.
bool is_rotation(const Mat3d& a);

}  // namespace enfilade
