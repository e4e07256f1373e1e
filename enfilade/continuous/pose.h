/// \file  Position and direction of a body in continuous environments.
#pragma once
#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/vec.h"

namespace enfilade::continuous {

/// World frame. Single precision, as Habitat and VLN-CE's files have positions.
struct Pose {
  Vec3f position;     ///< of the feet: a point of the floor, metres
  Radians heading;    ///< clockwise from +y, [0, 2 pi)
  Radians elevation;  ///< of the camera, up positive
};

}  // namespace enfilade::continuous
