/// \file  What a level plane cuts of a mesh: the lines that floor plans are drawn with.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh {

/// A straight piece of a cut, at the plane's height.
struct SliceLine {
  Vec3f from, to;                    ///< world, metres; apart
  std::uint32_t object = kNoObject;  ///< place in mesh.objects
};

/// One line for each triangle that reaches from below the height `z` to it or above; those that lie
/// in the plane give none. In the order of the triangles. \pre check() finds no errors; z is finite
std::vector<SliceLine> slice(const Mesh& mesh, float z);

}  // namespace enfilade::mesh
