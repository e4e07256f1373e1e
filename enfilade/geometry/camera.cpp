#include "enfilade/geometry/camera.h"

#include <fmt/format.h>
#include <cmath>

#include "enfilade/core/errors.h"

namespace enfilade {

Radians horizontal_field_of_view(const Camera& camera) {
  const double aspect = static_cast<double>(camera.width) / camera.height;
  return Radians(2 * std::atan(std::tan(camera.vertical_field_of_view.value / 2) * aspect));
}

void validate(const Camera& camera) {
  if (camera.width == 0 || camera.height == 0) {
    throw ArgumentError(fmt::format("camera size {} x {}: both must be at least 1 pixel",
                                    camera.width, camera.height));
  }
  const double vfov = camera.vertical_field_of_view.value;
  if (!(vfov > 0 && vfov < kPi)) {  // also refuses NaN
    throw ArgumentError(fmt::format(
        "camera vertical field of view {} rad: must be above 0 and below pi = {:.4f}", vfov, kPi));
  }
}

}  // namespace enfilade
