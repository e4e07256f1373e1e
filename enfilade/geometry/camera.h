/// \file  The pinhole camera of an agent.
#pragma once
#include <cstdint>

#include "enfilade/geometry/angle.h"

namespace enfilade {

/// Size and field of view of the pictures that an agent sees. A plain value.
struct Camera {
  std::uint32_t width = 640;                     ///< pixels, > 0
  std::uint32_t height = 480;                    ///< pixels, > 0
  Radians vertical_field_of_view = degrees(60);  ///< in (0, pi)

  friend constexpr bool operator==(const Camera&, const Camera&) = default;
};

/// The angle from the left to the right edge of the picture:
/// 2 atan(tan(vfov / 2) width / height). 75.2 degrees at 640 x 480 and 60 degrees.
Radians horizontal_field_of_view(const Camera& camera);

/// Checks all fields. \throws ArgumentError naming the field, its value and the allowed range
void validate(const Camera& camera);

}  // namespace enfilade
