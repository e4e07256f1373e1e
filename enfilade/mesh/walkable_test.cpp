#include "enfilade/mesh/walkable.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <set>

#include "tests/support/made_meshes.h"

namespace enfilade::mesh {
namespace EN_UNIT {

using testing::Maker;

// A cell's width: rims are blurred by that much, on either side.
constexpr double kCell = WalkableOptions().cell;

std::optional<std::uint32_t> part_at(const WalkableFloor& floor, Vec3f point, double drop = 0.3) {
  const auto cell = floor.below(point, drop);
  if (!cell) return std::nullopt;
  return floor.cells()[*cell].area;
}

bool joined(const WalkableFloor& floor, Vec3f a, Vec3f b) {
  const auto pa = part_at(floor, a), pb = part_at(floor, b);
  return pa && pb && *pa == *pb;
}

std::string code_of(const Mesh& mesh, const WalkableOptions& options = {}) {
  try {
    const WalkableFloor floor(mesh, options);
  } catch (const InvalidInput& e) {
    return e.diagnostics().front().code + ": " + e.diagnostics().front().message;
  }
  return "";
}

TEST(WalkableFloor, RoomIsFloorLessTheBodysRadius) {
  const WalkableFloor floor(Maker().room(0, 0, 5, 4).mesh);
  EXPECT_EQ(floor.areas(), 1U);
  const double inner = (5 - 2 * 0.25) * (4 - 2 * 0.25);
  // The rim, of that length, is right to half a cell on average.
  EXPECT_NEAR(floor.area_m2(), inner, 16 * kCell * 0.75);
  for (const FloorCell& cell : floor.cells()) {
    EXPECT_FLOAT_EQ(cell.position.z, 0);
    EXPECT_GE(cell.position.x, 0.25 - kCell);
    EXPECT_LE(cell.position.x, 4.75 + kCell);
    EXPECT_GE(cell.position.y, 0.25 - kCell);
    EXPECT_LE(cell.position.y, 3.75 + kCell);
  }
}

TEST(WalkableFloor, ClearanceIsTheDistanceToTheRim) {
  const WalkableFloor floor(Maker().room(0, 0, 6, 4).mesh);
  const auto clearance = [&](float x, float y) {
    return floor.cells()[floor.below({x, y, 0.1F}).value()].clearance;
  };
  EXPECT_NEAR(clearance(3, 2), 1.75, 2 * kCell);  // 2 m from walls, less 0.25
  EXPECT_NEAR(clearance(3, 1), 0.75, 2 * kCell);
  EXPECT_NEAR(clearance(0.6F, 2), 0.35, 2 * kCell);
}

TEST(WalkableFloor, NeighboursAreOneStepAwayAndMutual) {
  const WalkableFloor floor(testing::two_storeys().mesh);
  for (std::size_t c = 0; c < floor.cells().size(); ++c) {
    const std::set<std::uint32_t> once(floor.neighbours(c).begin(), floor.neighbours(c).end());
    ASSERT_EQ(once.size(), floor.neighbours(c).size());
    ASSERT_LE(once.size(), 8U);
    for (const std::uint32_t n : once) {
      const Vec3f way = floor.cells()[n].position - floor.cells()[c].position;
      ASSERT_LE(std::hypot(way.x, way.y), kCell * 1.42);
      ASSERT_LE(std::abs(way.z), 2 * 0.3);  // a corner is two steps
      ASSERT_EQ(floor.cells()[n].area, floor.cells()[c].area);
      const auto back = floor.neighbours(n);
      ASSERT_NE(std::find(back.begin(), back.end(), c), back.end());
    }
  }
}

TEST(WalkableFloor, DoorJoinsTwoRooms) {
  const WalkableFloor floor(Maker().room(0, 0, 8, 4).wall_with_hole(4, 0, 4, 1.5F, 2.4F).mesh);
  EXPECT_TRUE(joined(floor, {1, 2, 0.1F}, {7, 2, 0.1F}));
  EXPECT_FALSE(floor.below({4, 3.5F, 0.1F}));  // inside the wall
}

TEST(WalkableFloor, HoleTooNarrowPartsThem) {
  const WalkableFloor floor(Maker().room(0, 0, 8, 4).wall_with_hole(4, 0, 4, 1.5F, 1.9F).mesh);
  EXPECT_EQ(floor.areas(), 2U);
  EXPECT_FALSE(joined(floor, {1, 2, 0.1F}, {7, 2, 0.1F}));
}

TEST(WalkableFloor, HoleTooLowPartsThem) {
  const Mesh mesh = Maker().room(0, 0, 8, 4).wall_with_hole(4, 0, 4, 1.5F, 2.5F, 1.4F).mesh;
  EXPECT_FALSE(joined(WalkableFloor(mesh), {1, 2, 0.1F}, {7, 2, 0.1F}));
  WalkableOptions child;
  child.body.height = 1.3;
  EXPECT_TRUE(joined(WalkableFloor(mesh, child), {1, 2, 0.1F}, {7, 2, 0.1F}));
}

TEST(WalkableFloor, NobodyWalksBelowATableOrOnIt) {
  Maker m;
  m.room(0, 0, 5, 5).box({2, 2, 0.7F}, {3.2F, 3, 0.74F});
  const WalkableFloor floor(m.mesh);
  EXPECT_FALSE(floor.below({2.6F, 2.5F, 0.1F}));
  EXPECT_FALSE(floor.below({2.6F, 2.5F, 0.9F}, 0.3));
  EXPECT_TRUE(floor.below({1, 1, 0.1F}));
  EXPECT_EQ(floor.areas(), 1U);
}

TEST(WalkableFloor, SlopesUpToTheLimit) {
  const auto joins = [](float degrees) {
    const float rise = 3 * std::tan(degrees * 3.14159265F / 180);
    Maker m;
    m.level(0, 0, 3, 3, 0).ramp(3, 0, 6, 3, 0, rise).level(6, 0, 9, 3, rise);
    return joined(WalkableFloor(m.mesh), {1.5F, 1.5F, 0.1F}, {7.5F, 1.5F, rise + 0.1F});
  };
  EXPECT_TRUE(joins(35));
  EXPECT_FALSE(joins(50));
}

TEST(WalkableFloor, CellsOfARampAreOnIt) {
  const float rise = 2;
  Maker m;
  m.level(0, 0, 3, 3, 0).ramp(3, 0, 6, 3, 0, rise).level(6, 0, 9, 3, rise);
  const WalkableFloor floor(m.mesh);
  for (const FloorCell& cell : floor.cells()) {
    const float along = std::clamp((cell.position.x - 3) / 3, 0.0F, 1.0F);
    EXPECT_NEAR(cell.position.z, along * rise, 1e-4);  // single precision
  }
}

TEST(WalkableFloor, StairsJoinStoreysAboveEachOther) {
  const WalkableFloor floor(testing::two_storeys().mesh);
  EXPECT_TRUE(joined(floor, {3, 3, 0.1F}, {3, 3, 3.1F}));
  const auto middle = floor.below({2.82F, 0.5F, 1.7F}, 0.4);
  ASSERT_TRUE(middle);
  // The eighth tread begins at 0.9 + 7 * 4.1 / 16 = 2.69, and is 8 * 3 / 16 = 1.5 m high.
  EXPECT_NEAR(floor.cells()[*middle].position.z, 1.5, 1e-5);
  EXPECT_NEAR(floor.cells()[floor.below({3, 3, 2.9F}, 3).value()].position.z, 0, 1e-6);
  EXPECT_NEAR(floor.cells()[floor.below({3, 3, 3.5F}, 3).value()].position.z, 3, 1e-6);
}

TEST(WalkableFloor, StepsHigherThanTheBodyClimbsPart) {
  Maker m;
  m.level(0, 0, 6, 3, 0).box({3, 0, 0}, {6, 3, 0.4F});
  EXPECT_FALSE(joined(WalkableFloor(m.mesh), {1, 1.5F, 0.1F}, {5, 1.5F, 0.5F}));
  Maker low;
  low.level(0, 0, 6, 3, 0).box({3, 0, 0}, {6, 3, 0.25F});
  EXPECT_TRUE(joined(WalkableFloor(low.mesh), {1, 1.5F, 0.1F}, {5, 1.5F, 0.35F}));
}

TEST(WalkableFloor, WhichSideATriangleShowsDoesNotMatter) {
  Maker m;
  m.quad({0, 0, 0}, {0, 3, 0}, {3, 3, 0}, {3, 0, 0});
  EXPECT_EQ(WalkableFloor(m.mesh).areas(), 1U);
}

TEST(WalkableFloor, LargestPartComesFirst) {
  Maker m;
  m.level(0, 0, 2, 2, 0).level(10, 0, 15, 5, 0).level(20, 0, 23, 3, 0);
  const WalkableFloor floor(m.mesh);
  EXPECT_EQ(part_at(floor, {12, 2, 0}), 0U);
  EXPECT_EQ(part_at(floor, {21, 1, 0}), 1U);
  EXPECT_EQ(part_at(floor, {1, 1, 0}), 2U);
  WalkableOptions large;
  large.least_area = 5;
  EXPECT_EQ(WalkableFloor(m.mesh, large).areas(), 2U);
}

TEST(WalkableFloor, HouseComesBeforeTheMeadowAndItsRoofIsNone) {
  Maker m;
  m.room(0, 0, 5, 4).level(-8, -8, 12, 12, -0.3F);
  m.box({-0.2F, -0.2F, 2.7F}, {5.2F, 4.2F, 2.9F});
  const WalkableFloor floor(m.mesh);
  EXPECT_EQ(floor.areas(), 2U);
  const auto inside = floor.below({2, 2, 0.1F}, 0.2), outside = floor.below({-3, 2, 0}, 0.5);
  ASSERT_TRUE(inside && outside);
  EXPECT_EQ(floor.cells()[*inside].area, 0U);
  EXPECT_TRUE(floor.cells()[*inside].covered);
  EXPECT_EQ(floor.cells()[*outside].area, 1U);
  EXPECT_FALSE(floor.cells()[*outside].covered);
  EXPECT_FALSE(floor.below({2, 2, 3}, 0.3));  // the roof
}

TEST(WalkableFloor, NoFloorSaysWhy) {
  Maker wall, narrow, small;
  wall.box({0, 0, 0}, {0.1F, 4, 2});
  EXPECT_THAT(code_of(wall.mesh), ::testing::StartsWith("no-floor"));
  narrow.level(0, 0, 5, 0.4F, 0);
  EXPECT_THAT(code_of(narrow.mesh), ::testing::HasSubstr("radius"));
  small.level(0, 0, 1.3F, 1.3F, 0);
  EXPECT_THAT(code_of(small.mesh), ::testing::HasSubstr("largest connected floor"));
  EXPECT_THAT(code_of(Maker().ramp(0, 0, 1, 3, 0, 3).mesh),
              ::testing::HasSubstr("flatter than 40 degrees"));
}

TEST(WalkableFloor, BrokenMeshesAreRefused) {
  EXPECT_THAT(code_of(Mesh()), ::testing::StartsWith("no-triangles"));
  Maker m;
  m.level(0, 0, 5, 5, 0);
  m.mesh.positions[0].x = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THAT(code_of(m.mesh), ::testing::StartsWith("not-finite"));
}

TEST(WalkableFloor, AbsurdSizesNameCellAndExtent) {
  Maker m;
  m.level(0, 0, 1000, 1000, 0);
  try {
    const WalkableFloor floor(m.mesh);
    FAIL() << "was built";
  } catch (const ArgumentError& e) {
    EXPECT_THAT(e.what(), ::testing::HasSubstr("cell: 0.07 m on a mesh of 1000.0 x 1000.0"));
  }
  Maker tower;
  tower.level(0, 0, 5, 5, 0).level(0, 0, 5, 5, 1900);
  EXPECT_THROW(WalkableFloor(tower.mesh), ArgumentError);
  WalkableOptions bad;
  bad.cell = 0;
  EXPECT_THROW(WalkableFloor(Maker().room(0, 0, 5, 5).mesh, bad), ArgumentError);
  bad.cell = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(WalkableFloor(Maker().room(0, 0, 5, 5).mesh, bad), ArgumentError);
}

TEST(WalkableFloor, CellsGrowOnLargeMeshesIfAskedFor) {
  const Mesh small = Maker().room(0, 0, 5, 4).mesh, large = Maker().room(0, 0, 180, 180).mesh;
  const WalkableOptions growing{.growing_cell = true};
  EXPECT_EQ(WalkableFloor(small, growing).options().cell, kCell);
  const WalkableFloor floor(large, growing);
  EXPECT_DOUBLE_EQ(floor.options().cell, kCell * 1.25 * 1.25);
  EXPECT_EQ(floor.areas(), 1U);
  EXPECT_NEAR(floor.area_m2(), 179.5 * 179.5, 4 * 180 * floor.options().cell);
  EXPECT_THROW(WalkableFloor(Maker().room(0, 0, 300, 300).mesh, growing), ArgumentError);
}

TEST(WalkableFloor, BelowOutsideIsNothing) {
  const WalkableFloor floor(Maker().room(0, 0, 5, 4).mesh);
  EXPECT_FALSE(floor.below({-50, 2, 1}));
  EXPECT_FALSE(floor.below({2, 2, 10}));
  EXPECT_FALSE(floor.below({2, 2, -1}));
  EXPECT_FALSE(floor.below({std::numeric_limits<float>::quiet_NaN(), 2, 1}));
  EXPECT_TRUE(floor.below({2, 2, 2.4F}));
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh
