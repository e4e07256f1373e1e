/// \file  The horizontal direction of a camera, as the simulator compares it with edges.
#pragma once
#include <span>

#include "enfilade/geometry/angle.h"

namespace enfilade::sim::detail {

/// Where a camera points on the floor plan: of length 1, in single precision as MatterSim has it.
struct Direction {
  float x = 0, y = 1;
};

/// (cos, sin) of pi/2 - heading in double precision, rounded: the definition.
Direction direction_of(Radians heading);

/// The same bits, several times as fast. \pre headings in [0, 2 pi]; out.size() == headings.size()
void compute_directions(std::span<const double> headings, std::span<Direction> out);

}  // namespace enfilade::sim::detail
