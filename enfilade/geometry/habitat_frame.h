/// \file  Between our world frame and Habitat's, in which VLN-CE's files are written.
#pragma once
#include <cmath>

#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/vec.h"

namespace enfilade {

/// Our (x, y, z) with z up as Habitat's (x, z, -y) with y up. Exact.
template <class T>
constexpr Vec3<T> to_habitat(Vec3<T> ours) {
  return {ours.x, ours.z, -ours.y};
}
/// The way back. Exact.
template <class T>
constexpr Vec3<T> from_habitat(Vec3<T> theirs) {
  return {theirs.x, -theirs.z, theirs.y};
}

/// A rotation about Habitat's y axis: a quaternion (0, y, 0, w) of length 1, sign free.
struct HabitatYaw {
  double y = 0, w = 1;
};
/// Our heading, clockwise from +y, as Habitat's rotation from -z, which is the same direction:
/// counter-clockwise seen from above.
inline HabitatYaw to_habitat(Radians heading) {
  return {std::sin(-heading.value / 2), std::cos(heading.value / 2)};
}
/// The way back: a heading in [0, 2 pi). \pre not both are 0
inline Radians from_habitat(HabitatYaw yaw) {
  const double heading = -2 * std::atan2(yaw.y, yaw.w);
  const double turns = std::floor(heading / (2 * kPi));
  const double wrapped = heading - 2 * kPi * turns;
  return Radians(wrapped < 2 * kPi ? wrapped : 0);
}

}  // namespace enfilade
