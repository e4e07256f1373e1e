/// \file  Level floors of rectangles, in Habitat's frame: metres, y up.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/continuous/habitat/path_finder.h"

namespace enfilade::continuous::habitat::testing {

/// Seen from above.
struct Rectangle {
  float x0, z0, x1, z1;
};

/// Level rectangles, two triangles each. Where no rectangle is, bodies cannot go: a gap is a wall.
inline Triangles flat_triangles(const std::vector<Rectangle>& rectangles, float height = 0) {
  Triangles made;
  for (const auto& [x0, z0, x1, z1] : rectangles) {
    const auto first = static_cast<std::int32_t>(made.corners.size());
    made.corners.insert(made.corners.end(),
                        {{x0, height, z0}, {x0, height, z1}, {x1, height, z1}, {x1, height, z0}});
    made.triangles.push_back({first, first + 1, first + 2});
    made.triangles.push_back({first, first + 2, first + 3});
  }
  return made;
}

/// The floor on them.
inline PathFinder flat_floor(const std::vector<Rectangle>& rectangles) {
  return PathFinder(make_nav_mesh(flat_triangles(rectangles)));
}

}  // namespace enfilade::continuous::habitat::testing
