/// \file  Positions and directions in the world frame: metres, +z up, right-handed.
#pragma once
#include <cmath>

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

}  // namespace enfilade
