#include "enfilade/geometry/vec.h"

namespace enfilade {

bool is_rotation(const Mat3d& a) {
  const Mat3d product = transpose(a) * a, identity;
  for (std::size_t i = 0; i < 9; ++i) {
    if (!(std::abs(product.m[i] - identity.m[i]) <= kRotationTolerance)) return false;
  }
  const Vec3d x{a.m[0], a.m[3], a.m[6]}, y{a.m[1], a.m[4], a.m[7]}, z{a.m[2], a.m[5], a.m[8]};
  return dot(cross(x, y), z) > 0;
}

}  // namespace enfilade
