/// \file  Horizontal cross-sections of a mesh, for floor plans.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh {

/// A segment of a cross-section.
struct SliceLine {
  Vec3f from, to;                    ///< world, metres; not equal
  std::uint32_t object = kNoObject;  ///< index in mesh.objects
};

/// Cross-section at height `z`, in the order of the triangles. Each triangle with a corner below z
/// and one at or above it gives a line. Triangles in the plane give none.
/// \pre check() finds no errors; z is finite
std::vector<SliceLine> slice(const Mesh& mesh, float z);

}  // namespace enfilade::mesh
