/// \file  Positions and directions in the world frame: metres, +z up, right-handed.
#pragma once
#include <cmath>

namespace enfilade {

template <class T>
struct Vec3 {
  T x = 0, y = 0, z = 0;

  friend constexpr bool operator==(const Vec3&, const Vec3&) = default;
  friend constexpr Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend constexpr Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
};

/// Single precision: what the simulator, like MatterSim, computes views with.
using Vec3f = Vec3<float>;
/// Double precision: what lengths of paths are summed in.
using Vec3d = Vec3<double>;

template <class T>
T length(Vec3<T> v) {
  return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z);
}

}  // namespace enfilade
