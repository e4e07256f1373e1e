/// \file  Positions and directions in the world frame: metres, +z up, right-handed; rotations
/// between frames.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>

namespace enfilade {

/// A point or vector in three dimensions; 0 by default.
template <class T>
struct Vec3 {
  T x = 0, y = 0, z = 0;

  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
  friend constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
  friend constexpr Vec3 operator-(Vec3 v) { return {-v.x, -v.y, -v.z}; }
  friend constexpr Vec3 operator*(T k, Vec3 v) { return {k * v.x, k * v.y, k * v.z}; }
  friend constexpr Vec3& operator+=(Vec3& a, Vec3 b) { return a = a + b; }
};

/// Single precision: used by the simulator for views, as by MatterSim.
using Vec3f = Vec3<float>;
/// Double precision: used for lengths of paths.
using Vec3d = Vec3<double>;

/// The scalar product.
template <class T>
constexpr T dot(Vec3<T> a, Vec3<T> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Cross product, right-handed: cross(x, y) is z.
template <class T>
constexpr Vec3<T> cross(Vec3<T> a, Vec3<T> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Euclidean length.
template <class T>
T length(Vec3<T> v) {
  return std::sqrt(dot(v, v));
}

/// Rounded to nearest. \pre all components are in the range of float
constexpr Vec3f to_float(Vec3d v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}
constexpr Vec3d to_double(Vec3f v) { return {v.x, v.y, v.z}; }

/// 3 x 3 matrix, row-major. Variables name both frames: `world_from_panorama * v` converts v from
/// the panorama frame to the world frame. The default is the identity.
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

/// A pose as files have it: a 4 x 4 matrix, row-major, with the rotation, the position (metres) in
/// the last column and 0 0 0 1 in the last row. Both arguments convert between the same two frames.
constexpr std::array<double, 16> pose_matrix(const Mat3d& r, Vec3d p) {
  return {r.m[0], r.m[1], r.m[2], p.x, r.m[3], r.m[4], r.m[5], p.y,
          r.m[6], r.m[7], r.m[8], p.z, 0,      0,      0,      1};
}
/// The upper left 3 x 3 part of such a matrix.
constexpr Mat3d rotation_of(const std::array<double, 16>& pose) {
  return {{pose[0], pose[1], pose[2], pose[4], pose[5], pose[6], pose[8], pose[9], pose[10]}};
}

/// Largest deviation of an element of R^T R from the identity's, in a rotation. Poses in files have
/// six digits, which gives errors of 1e-6; scaled or sheared frames are far above this limit.
inline constexpr double kRotationTolerance = 1e-3;

/// True if the matrix is orthonormal to kRotationTolerance and right-handed; false if a number is
/// not finite.
bool is_rotation(const Mat3d& a);

}  // namespace enfilade
