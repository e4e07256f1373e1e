#include "enfilade/mesh/floor_polygons.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tests/support/made_meshes.h"

namespace enfilade::mesh {
namespace {

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

}  // namespace
}  // namespace enfilade::mesh
