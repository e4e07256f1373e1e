#include "enfilade/mesh/floor_polygons.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tests/support/made_meshes.h"

namespace enfilade::mesh {
namespace EN_UNIT {

using testing::Maker;

FloorPolygons polygons_of(Mesh mesh, const PolygonOptions& options = {}) {
  const RayTracer tracer(std::make_shared<const Mesh>(std::move(mesh)));
  return make_floor_polygons(tracer, options);
}

Vec3d place(const FloorPolygons& f, std::size_t corner) {
  const PolygonCorner& c = f.corners[corner];
  return {f.low.x + f.cell * c[0], f.low.y + f.cell * c[1], f.low.z + f.level * c[2]};
}

double area_of(const FloorPolygons& f, std::size_t polygon) {
  double twice = 0;
  const FloorPolygon& p = f.polygons[polygon];
  for (std::size_t k = 2; k < p.size(); ++k) {
    const Vec3d a = place(f, p.corners[0]);
    twice += cross(place(f, p.corners[k - 1]) - a, place(f, p.corners[k]) - a).z;
  }
  return std::abs(twice) / 2;
}

TEST(FloorPolygons, ARoomIsARectangleLessTheBodysRadius) {
  const FloorPolygons f = polygons_of(Maker().room(0, 0, 5, 4).mesh);
  ASSERT_FALSE(f.polygons.empty());
  double area = 0;
  for (std::size_t p = 0; p < f.polygons.size(); ++p) area += area_of(f, p);
  // The rim of 17 m is right to half a cell on average, and may be cut by rim_error.
  EXPECT_NEAR(area, 4.8 * 3.8, 17 * 0.02);
  for (std::size_t c = 0; c < f.corners.size(); ++c) {
    EXPECT_GE(place(f, c).x, 0.1 - 0.05);
    EXPECT_LE(place(f, c).x, 4.9 + 0.05);
    EXPECT_GE(place(f, c).y, 0.1 - 0.05);
    EXPECT_LE(place(f, c).y, 3.9 + 0.05);
  }
  ASSERT_EQ(f.heights.size(), f.polygons.size());
  for (const Vec3f point : f.points) EXPECT_NEAR(point.z, 0, 1e-6);
}

// Rank and areas are the walkable floor's.
TEST(FloorPolygons, AreasAreTheConnectedPartsOfTheFloor) {
  Mesh mesh = Maker().room(0, 0, 5, 4).mesh;
  append(mesh, Maker().room(10, 0, 13, 3).mesh);
  const FloorPolygons f = polygons_of(mesh);
  std::array<double, 2> areas{};
  for (std::size_t p = 0; p < f.polygons.size(); ++p) {
    ASSERT_LT(f.polygons[p].area, 2U);
    areas[f.polygons[p].area] += area_of(f, p);
    EXPECT_EQ(f.polygons[p].area == 0, place(f, f.polygons[p].corners[0]).x < 7);
  }
  EXPECT_GT(areas[0], areas[1]);
  EXPECT_GT(areas[1], 7);
}

TEST(FloorPolygons, SidesKnowEachOther) {
  const FloorPolygons f = polygons_of(testing::two_storeys().mesh);
  std::size_t inner = 0;
  for (std::size_t p = 0; p < f.polygons.size(); ++p) {
    for (std::size_t k = 0; k < f.polygons[p].size(); ++k) {
      const std::uint16_t beyond = f.polygons[p].beyond[k];
      if (beyond == FloorPolygon::kNone) continue;
      ++inner;
      ASSERT_LT(beyond, f.polygons.size());
      const auto& back = f.polygons[beyond].beyond;
      EXPECT_NE(std::find(back.begin(), back.end(), p), back.end());
      EXPECT_EQ(f.polygons[beyond].area, f.polygons[p].area);
    }
  }
  EXPECT_GT(inner, 0U);
}

double area_of(const FloorPolygons& f) {
  double area = 0;
  for (std::size_t p = 0; p < f.polygons.size(); ++p) area += area_of(f, p);
  return area;
}

TEST(FloorPolygons, DoNotDependOnWhichSideIsTheFront) {
  Mesh mesh = testing::two_storeys().mesh;
  const FloorPolygons good = polygons_of(mesh);
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 2) {
    std::swap(mesh.triangles[t][0], mesh.triangles[t][1]);
  }
  EXPECT_TRUE(polygons_of(mesh) == good);
}

// A floor of 5 x 4 m in four pieces around a hole of 1 x 1 m, under a ceiling.
TEST(FloorPolygons, GoAroundHoles) {
  Maker made;
  made.level(0, 0, 2, 4, 0).level(3, 0, 5, 4, 0).level(2, 0, 3, 1.5F, 0).level(2, 2.5F, 3, 4, 0);
  made.level(0, 0, 5, 4, 2.6F);
  const FloorPolygons f = polygons_of(made.mesh);
  // Nothing is there to touch: a body's middle may be up to its radius from the hole's rim, as
  // Recast keeps that much from every rim.
  EXPECT_NEAR(area_of(f), 4.8 * 3.8 - 1.2 * 1.2, 22 * 0.02);
}

TEST(FloorPolygons, LargeFloorsHaveLargerCells) {
  const FloorPolygons f = polygons_of(Maker().room(0, 0, 30, 25).mesh);
  EXPECT_GT(f.cell, PolygonOptions().floor.cell);
  EXPECT_NEAR(area_of(f), 29.8 * 24.8, 110 * f.cell);
}

TEST(FloorPolygons, LieInTheBoxThatIsAskedFor) {
  PolygonOptions options;
  options.floor.within = Box{{0, 0, -1}, {2, 4, 3}};
  const FloorPolygons f = polygons_of(Maker().room(0, 0, 5, 4).mesh, options);
  for (std::size_t c = 0; c < f.corners.size(); ++c) EXPECT_LE(place(f, c).x, 2.1);
  options.floor.within = Box{{50, 50, -1}, {52, 54, 3}};
  EXPECT_THROW(polygons_of(Maker().room(0, 0, 5, 4).mesh, options), InvalidInput);
}

TEST(FloorPolygons, OptionsOutOfRangeAreNamed) {
  const auto message = [](const PolygonOptions& options) -> std::string {
    try {
      polygons_of(Maker().room(0, 0, 5, 4).mesh, options);
    } catch (const ArgumentError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_EQ(message({.rim_error = -1}).substr(0, 9), "rim_error");
  EXPECT_EQ(message({.height_every = 0}).substr(0, 12), "height_every");
  PolygonOptions cells;
  cells.floor.cell = 0;
  EXPECT_EQ(message(cells).substr(0, 4), "cell");
}

TEST(FloorPolygons, AMeshWithoutAFloorSaysWhy) {
  Mesh wall;
  wall.positions = {{0, 0, 0}, {5, 0, 0}, {0, 0, 3}};
  wall.triangles = {{0, 1, 2}};
  wall.triangle_material = {0};
  wall.materials.emplace_back();
  EXPECT_THROW(polygons_of(wall), InvalidInput);
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh
