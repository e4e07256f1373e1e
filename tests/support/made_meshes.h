/// \file  Small buildings of boxes, whose floors and passages can be worked out by hand.
#pragma once
#include <array>
#include <cstdint>

#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh::testing {

/// Adds pieces to one mesh of one material. Metres, z up.
class Maker {
 public:
  Maker() { mesh.materials.emplace_back(); }

  Maker& triangle(Vec3f a, Vec3f b, Vec3f c) {
    const auto first = static_cast<std::uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {a, b, c});
    mesh.triangles.push_back({first, first + 1, first + 2});
    mesh.triangle_material.push_back(0);
    return *this;
  }
  Maker& quad(Vec3f a, Vec3f b, Vec3f c, Vec3f d) { return triangle(a, b, c).triangle(a, c, d); }

  /// Six sides, seen from outside.
  Maker& box(Vec3f l, Vec3f h) {
    quad({l.x, l.y, h.z}, {h.x, l.y, h.z}, h, {l.x, h.y, h.z});
    quad(l, {l.x, h.y, l.z}, {h.x, h.y, l.z}, {h.x, l.y, l.z});
    quad(l, {h.x, l.y, l.z}, {h.x, l.y, h.z}, {l.x, l.y, h.z});
    quad({l.x, h.y, l.z}, {l.x, h.y, h.z}, h, {h.x, h.y, l.z});
    quad(l, {l.x, l.y, h.z}, {l.x, h.y, h.z}, {l.x, h.y, l.z});
    return quad({h.x, l.y, l.z}, {h.x, h.y, l.z}, h, {h.x, l.y, h.z});
  }

  /// A level rectangle at height z.
  Maker& level(float x0, float y0, float x1, float y1, float z) {
    return quad({x0, y0, z}, {x1, y0, z}, {x1, y1, z}, {x0, y1, z});
  }

  /// Floor, ceiling and four walls 0.1 m thick around the inner faces.
  Maker& room(float x0, float y0, float x1, float y1, float z = 0, float height = 2.6F) {
    level(x0, y0, x1, y1, z).level(x0, y0, x1, y1, z + height);
    constexpr float kThick = 0.1F;
    box({x0 - kThick, y0 - kThick, z}, {x0, y1 + kThick, z + height});
    box({x1, y0 - kThick, z}, {x1 + kThick, y1 + kThick, z + height});
    box({x0, y0 - kThick, z}, {x1, y0, z + height});
    return box({x0, y1, z}, {x1, y1 + kThick, z + height});
  }

  /// A wall across a room at x, from y0 to y1, 0.1 m thick, with a hole in it.
  Maker& wall_with_hole(float x, float y0, float y1, float from, float to, float head = 2.05F,
                        float height = 2.6F) {
    const float a = x - 0.05F, b = x + 0.05F;
    box({a, y0, 0}, {b, from, height});
    box({a, to, 0}, {b, y1, height});
    if (head < height) box({a, from, head}, {b, to, height});
    return *this;
  }

  /// A slope towards +x.
  Maker& ramp(float x0, float y0, float x1, float y1, float z0, float z1) {
    return quad({x0, y0, z0}, {x1, y0, z1}, {x1, y1, z1}, {x0, y1, z0});
  }

  /// Solid steps towards +x from height z0 to z1: the last one is `steps` high.
  Maker& stairs(float x0, float y0, float y1, float tread, int steps, float z0, float z1) {
    const float rise = (z1 - z0) / static_cast<float>(steps);
    for (int i = 0; i < steps; ++i) {
      const float x = x0 + static_cast<float>(i) * tread;
      box({x, y0, z0}, {x + tread, y1, z0 + static_cast<float>(i + 1) * rise});
    }
    return *this;
  }

  Mesh mesh;
};

/// Two storeys, 6 x 4 m each, floors at 0 and 3 m, and a flight of 16 steps in a well between them:
/// it climbs towards +x along the wall y = 0, from x = 0.9 to 5, 1 m wide.
inline Maker two_storeys() {
  Maker m;
  m.level(0, 0, 6, 4, 0).level(0, 0, 6, 4, 5.6F);
  for (const float z : {0.0F, 3.0F}) {
    const float top = z + 3.0F;
    m.box({-0.1F, -0.1F, z}, {0, 4.1F, top}).box({6, -0.1F, z}, {6.1F, 4.1F, top});
    m.box({0, -0.1F, z}, {6, 0, top}).box({0, 4, z}, {6, 4.1F, top});
  }
  // The upper floor, 0.2 m thick, around the well (x from 0.5 to 5, y from 0 to 1).
  m.box({0, 1, 2.8F}, {6, 4, 3}).box({5, 0, 2.8F}, {6, 1, 3}).box({0, 0, 2.8F}, {0.5F, 1, 3});
  // Railings: along the well and at its low end.
  m.box({0.5F, 1, 3}, {5, 1.05F, 3.9F}).box({0.45F, 0, 3}, {0.5F, 1, 3.9F});
  m.stairs(0.9F, 0, 1, 4.1F / 16, 16, 0, 3);
  return m;
}

}  // namespace enfilade::mesh::testing
