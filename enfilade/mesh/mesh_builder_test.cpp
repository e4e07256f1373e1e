#include "enfilade/mesh/mesh_builder.h"

#include <gtest/gtest.h>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::mesh {
namespace EN_UNIT {

struct Built {
  Mesh mesh;
  MeshBuilder builder{mesh};
  MaterialId paint = builder.add_material({}, 1);
};

/// Six times the volume that the triangles enclose, by the divergence theorem: positive only if
/// they face outwards.
double volume(const Mesh& m) {
  double sum = 0;
  for (const auto& t : m.triangles) {
    sum += dot(to_double(m.positions[t[0]]),
               cross(to_double(m.positions[t[1]]), to_double(m.positions[t[2]])));
  }
  return sum / 6;
}

/// Each edge is used once in each direction.
bool closed(const Mesh& m) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges;
  for (const auto& t : m.triangles) {
    for (std::size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  }
  for (const auto& [edge, uses] : edges) {
    const auto back = edges.find({edge.second, edge.first});
    if (uses != 1 || back == edges.end() || back->second != 1) return false;
  }
  return true;
}

void expect_sound(const Mesh& m) {
  ASSERT_FALSE(m.triangles.empty());
  EXPECT_TRUE(check(m, "built").empty());
  ASSERT_EQ(m.normals.size(), m.triangles.size());
  ASSERT_EQ(m.texture_points.size(), m.triangles.size());
  for (std::size_t i = 0; i < m.triangles.size(); ++i) {
    const auto& t = m.triangles[i];
    const Vec3d a = to_double(m.positions[t[0]]);
    const Vec3d facing = cross(to_double(m.positions[t[1]]) - a, to_double(m.positions[t[2]]) - a);
    for (const Vec3f n : m.normals[i]) {
      EXPECT_NEAR(length(n), 1, 1e-5);              // single precision
      EXPECT_GT(dot(to_double(n), facing), -1e-9);  // shading normals may lean, never look inwards
    }
  }
}

struct Solid {
  const char* name;
  std::function<void(MeshBuilder&, MaterialId)> add;
  double volume, tolerance;
};

std::vector<Solid> solids() {
  const double pi = std::numbers::pi;
  static constexpr std::array<std::array<double, 2>, 5> kBowl{
      {{0, 0}, {0.5, 0.5}, {0.45, 0.5}, {0.2, 0.25}, {0, 0.1}}};
  // Polygons of n sides have (n / 2 pi) sin(2 pi / n) of the circle's area; 16 sides: 0.974.
  return {{"box",
           [](auto& b, auto m) {
             b.box(m, {1, 2, 3}, {2, 4, 6});
           },
           6, 1e-5},
          {"soft",
           [](auto& b, auto m) {
             b.soft_box(m, {0, 0, 0}, {1, 2, 1}, 0.1);
           },
           2 - 0.005 * (16 - 2.4) - 8 * 0.001 * 5 / 6, 1e-3},
          {"cylinder",
           [](auto& b, auto m) {
             b.cylinder(m, {3, 0, 1}, 1, 1, 2, 16);
           },
           2 * pi * 0.97450, 1e-3},
          {"cone",
           [](auto& b, auto m) {
             b.cylinder(m, {3, 0, 1}, 1, 0, 3, 16);
           },
           pi * 0.97450, 1e-3},
          {"sphere",
           [](auto& b, auto m) {
             b.sphere(m, {1, 1, 1}, 1, 64);
           },
           4 * pi / 3, 0.03},
          {"bar",
           [](auto& b, auto m) {
             b.bar(m, {0, 0, 0}, {1, 2, 2}, 0.5, 16);
           },
           3 * pi * 0.25 * 0.97450, 1e-3},
          {"bowl",
           [](auto& b, auto m) {
             b.lathe(m, {0, 0, 0}, kBowl, 32);
           },
           0.03751 * 0.99359, 1e-4}};
}

TEST(MeshBuilder, SolidsAreClosedAndFaceOutwards) {
  for (const Solid& solid : solids()) {
    SCOPED_TRACE(solid.name);
    Built built;
    built.builder.begin_object("thing", Mpcat40::kObjects, 0, {{1, -2, 0.5}, 0.7});
    solid.add(built.builder, built.paint);
    expect_sound(built.mesh);
    EXPECT_TRUE(closed(built.mesh));
    EXPECT_NEAR(volume(built.mesh), solid.volume, solid.tolerance);
  }
}

TEST(MeshBuilder, ABoxWithoutBottomIsOpen) {
  Built built;
  built.builder.box(built.paint, {0, 0, 0}, {1, 1, 1}, false);
  EXPECT_EQ(built.mesh.triangles.size(), 10U);
  EXPECT_FALSE(closed(built.mesh));
  EXPECT_EQ(built.mesh.triangle_object[0], kNoObject);
}

TEST(MeshBuilder, TexturePointsAreMetresOverTheTexturesSize) {
  Built built;
  const MaterialId tile = built.builder.add_material({}, 0.5);
  built.builder.quad(tile, {0, 0, 0}, {2, 0, 0}, {2, 0, 1}, {0, 0, 1});  // a wall, facing -y
  const auto& p = built.mesh.texture_points;
  EXPECT_FLOAT_EQ(p[0][1].u - p[0][0].u, 4);   // 2 m to the right
  EXPECT_FLOAT_EQ(p[0][2].v - p[0][1].v, -2);  // 1 m up
}

TEST(MeshBuilder, SizeZeroStretchesATextureOnceOverAFace) {
  Built built;
  const MaterialId picture = built.builder.add_material({}, 0);
  built.builder.quad(picture, {0, 0, 0}, {2, 0, 0}, {2, 0, 1}, {0, 0, 1});
  const auto& p = built.mesh.texture_points;
  EXPECT_FLOAT_EQ(p[0][0].u, 0);  // bottom left
  EXPECT_FLOAT_EQ(p[0][0].v, 1);
  EXPECT_FLOAT_EQ(p[1][2].u, 0);  // top left
  EXPECT_FLOAT_EQ(p[1][2].v, 0);
}

TEST(MeshBuilder, TurnsAndMovesObjects) {
  Built built;
  const Placement placement{{10, 20, 0}, std::numbers::pi / 2};
  EXPECT_EQ(placement.to_world({1, 0, 2}), (Vec3d{10, 21, 2}));  // quarter turns are exact
  const auto first = built.builder.begin_object("table", Mpcat40::kTable, 3, placement);
  built.builder.box(built.paint, {0, 0, 0}, {2, 1, 1});
  const auto second = built.builder.begin_object("chair", Mpcat40::kChair, 3);
  EXPECT_EQ(first, 0U);
  EXPECT_EQ(second, 1U);
  const Box box = bounds(built.mesh);
  EXPECT_EQ(box.low, (Vec3f{9, 20, 0}));
  EXPECT_EQ(box.high, (Vec3f{10, 22, 1}));
  EXPECT_EQ(built.mesh.positions.size(), 8U);
  EXPECT_EQ(built.mesh.objects[1].name, "chair");
  EXPECT_EQ(built.mesh.objects[0].region, 3);
}

TEST(MeshBuilder, RefusesABadTextureSize) {
  Built built;
  EXPECT_THROW(built.builder.add_material({}, -1), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh
