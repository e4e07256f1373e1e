#include "enfilade/draw/plan_underlay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "enfilade/core/errors.h"
#include "enfilade/draw/floor_plan.h"
#include "tests/support/made_meshes.h"

namespace enfilade::draw {
namespace EN_UNIT {

using mesh::testing::Maker;
using ::testing::HasSubstr;
using ::testing::Not;
using Kind = UnderlayLine::Kind;

// Viewpoints at these places, 1.5 m above floors, without edges.
graph::NavGraph graph_at(const std::vector<Vec3d>& floors) {
  scan::Connectivity c{"made", "made_connectivity.json", {}};
  for (const Vec3d& p : floors) {
    scan::ConnectivityEntry entry;
    entry.id = "v" + std::to_string(c.entries.size());
    entry.pose = {1, 0, 0, p.x, 0, 0, 1, p.y, 0, -1, 0, p.z + 1.5, 0, 0, 0, 1};
    entry.height = 1.5;
    c.entries.push_back(entry);
  }
  return graph::NavGraph(c);
}

const graph::NavGraph& one_room() {
  static const graph::NavGraph kGraph = graph_at({{1, 1, 0}, {3, 1, 0}, {5, 3, 0}});
  return kGraph;
}

// A room 6 x 4 m with a table, a window in its wall and a door leaf.
mesh::Mesh furnished() {
  Maker maker;
  std::vector<std::size_t> ends;
  const auto end = [&] { ends.push_back(maker.mesh.triangles.size()); };
  maker.room(0, 0, 6, 4);
  end();
  maker.box({2, 2, 0}, {4, 3, 0.7F});
  end();
  maker.box({1, -0.07F, 0.9F}, {2, -0.03F, 2});
  end();
  maker.box({4, 0, 0}, {4.04F, 0.9F, 2});
  end();
  maker.mesh.objects = {{"wall", 1, 0}, {"table", 5, 0}, {"window", 9, 0}, {"door", 4, 0}};
  for (std::uint32_t object = 0; object < ends.size(); ++object) {
    maker.mesh.triangle_object.resize(ends[object], object);
  }
  return maker.mesh;
}

std::size_t count(const UnderlayStorey& storey, Kind kind) {
  return static_cast<std::size_t>(std::ranges::count(storey.lines, kind, &UnderlayLine::kind));
}

TEST(PlanUnderlay, CutsKindsAtTheirHeights) {
  const PlanUnderlay underlay = plan_underlay(furnished(), one_room());
  ASSERT_EQ(underlay.storeys.size(), 1U);
  const UnderlayStorey& storey = underlay.storeys[0];
  // Two triangles a side of a box.
  EXPECT_EQ(count(storey, Kind::kWall), 32U);
  EXPECT_EQ(count(storey, Kind::kThing), 8U);
  EXPECT_EQ(count(storey, Kind::kWindow), 1U);  // down its middle
  EXPECT_EQ(count(storey, Kind::kDoor), 8U);
  for (const UnderlayLine& line : storey.lines) {
    EXPECT_FLOAT_EQ(line.from.z, line.kind == Kind::kThing ? 0.45F : 1.2F);
    if (line.kind != Kind::kWindow) continue;
    EXPECT_NEAR(std::min(line.from.x, line.to.x), 1, 0.01);
    EXPECT_NEAR(std::max(line.from.x, line.to.x), 2, 0.01);
    EXPECT_NEAR(line.from.y, -0.05, 0.01);  // where triangles meet on its sides shifts it
  }
}

TEST(PlanUnderlay, WithoutLabelsWhatIsTallIsAWallToo) {
  mesh::Mesh bare = furnished();
  bare.objects.clear();
  bare.triangle_object.clear();
  const PlanUnderlay underlay = plan_underlay(bare, one_room());
  EXPECT_EQ(count(underlay.storeys[0], Kind::kWall), 48U);   // not the table
  EXPECT_EQ(count(underlay.storeys[0], Kind::kThing), 48U);  // not the window
}

TEST(PlanUnderlay, StoreysAreCutEachAndStairsBetween) {
  Maker maker = mesh::testing::two_storeys();
  const std::size_t house = maker.mesh.triangles.size();
  maker.stairs(8, 0, 1, 0.25F, 16, 0, 3);
  maker.mesh.objects = {{"wall", 1, 0}, {"stairs", 16, 0}};
  maker.mesh.triangle_object.assign(house, 0);
  maker.mesh.triangle_object.resize(maker.mesh.triangles.size(), 1);
  std::vector<Vec3d> floors;
  for (const double z : {0.0, 3.0}) {
    for (const double x : {1.0, 3.0, 5.0, 9.0}) floors.push_back({x, 3, z});
  }
  PlanUnderlay underlay = plan_underlay(maker.mesh, graph_at(floors));
  ASSERT_EQ(underlay.storeys.size(), 2U);
  EXPECT_GT(count(underlay.storeys[0], Kind::kWall), 0U);
  EXPECT_GT(count(underlay.storeys[1], Kind::kWall), 0U);
  EXPECT_GT(count(underlay.storeys[0], Kind::kStairs), 16U);
  EXPECT_EQ(count(underlay.storeys[1], Kind::kStairs), 0U);
  for (const UnderlayLine& line : underlay.storeys[1].lines) EXPECT_GT(line.from.z, 3);
}

TEST(PlanUnderlay, LinesAreWrittenAsFourNumbersOfAKind) {
  const std::vector<UnderlayLine> lines{{Kind::kDoor, {1.00049F, 2, 0}, {3, -4.0006F, 0}},
                                        {Kind::kWall, {9, 9, 0}, {8, 8, 0}}};
  EXPECT_EQ(line_ends(lines, Kind::kDoor), (std::vector<double>{1, 2, 3, -4.001}));
  EXPECT_EQ(line_ends(lines, Kind::kDoor, 0.01), (std::vector<double>{1, 2, 3, -4}));
  EXPECT_TRUE(line_ends(lines, Kind::kStairs).empty());
}

TEST(PlanUnderlay, LeavesOutWhatIsFarAway) {
  Maker maker;
  maker.room(0, 0, 6, 4).box({20, 20, 0}, {21, 21, 3});
  const PlanUnderlay underlay = plan_underlay(maker.mesh, one_room());
  for (const UnderlayLine& line : underlay.storeys[0].lines) EXPECT_LT(line.from.x, 10);
  EXPECT_FALSE(underlay.storeys[0].lines.empty());
}

TEST(FloorPlan, DrawsTheUnderlayInsteadOfShading) {
  PlanUnderlay underlay = plan_underlay(furnished(), one_room());
  underlay.storeys.front().texts.push_back({{3, 2, 0}, "bed & breakfast"});
  FloorPlanOptions options;
  options.underlay = &underlay;
  const std::string svg = floor_plan_svg(one_room(), {}, options);
  for (const char* text : {">wall<", ">door<", ">window<", ">furniture<", "bed &amp; breakfast"}) {
    EXPECT_THAT(svg, HasSubstr(text));
  }
  EXPECT_THAT(svg, Not(HasSubstr(">stairs<")));
  EXPECT_THAT(svg, Not(HasSubstr("of an edge or viewpoint")));
  EXPECT_THAT(floor_plan_svg(one_room()), HasSubstr("of an edge or viewpoint"));
}

TEST(FloorPlan, RefusesAnUnderlayOfAnotherBuilding) {
  const PlanUnderlay other;
  FloorPlanOptions options;
  options.underlay = &other;
  EXPECT_THROW(floor_plan_svg(one_room(), {}, options), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw
