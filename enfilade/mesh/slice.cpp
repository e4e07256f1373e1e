#include "enfilade/mesh/slice.h"

#include <array>

namespace enfilade::mesh {
namespace {

// From the lower end, whichever way a triangle runs along it, so that neighbours meet exactly.
Vec3f crossing(Vec3f low, Vec3f high, float z) {
  const float share = (z - low.z) / (high.z - low.z);
  return {low.x + share * (high.x - low.x), low.y + share * (high.y - low.y), z};
}

}  // namespace

std::vector<SliceLine> slice(const Mesh& mesh, float z) {
  std::vector<SliceLine> lines;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    std::array<Vec3f, 2> ends;
    std::size_t found = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f a = mesh.positions[mesh.triangles[t][k]];
      const Vec3f b = mesh.positions[mesh.triangles[t][(k + 1) % 3]];
      // Half-open, so that a corner in the plane counts once.
      if ((a.z < z) == (b.z < z)) continue;
      ends[found++] = a.z < b.z ? crossing(a, b, z) : crossing(b, a, z);
    }
    if (found != 2 || ends[0] == ends[1]) continue;
    lines.push_back({ends[0], ends[1], object_of(mesh, t)});
  }
  return lines;
}

}  // namespace enfilade::mesh
