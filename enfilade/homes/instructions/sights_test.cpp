#include "enfilade/homes/instructions/speaker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "enfilade/mesh/mesh_builder.h"
#include "enfilade/mesh/mpcat40.h"
#include "tests/support/graphs.h"
#include "tests/support/instructions/box_home.h"

namespace enfilade::homes::instructions {
namespace EN_UNIT {

constexpr double kPi = std::numbers::pi;

// A cube of 0.4 m around (3, 0, 1.5), seen from (0, 0, 1.5), and one behind it.
Home two_cubes() {
  Home home;
  home.plan.storeys = {{0, 3}};
  home.plan.rooms = {{'l', "living room", 0, {-1, -1, 1, 1}, 2.6},
                     {'h', "hallway", 0, {1.2, -1, 9, 1}, 2.6}};
  mesh::MeshBuilder builder(home.mesh);
  const mesh::MaterialId paint = builder.add_material({});
  for (const double x : {3.0, 6.0}) {
    const Vec3d low{x - 0.2, -0.2, 1.3}, high{x + 0.2, 0.2, 1.7};
    const std::uint32_t object = builder.begin_object("cube", mesh::Mpcat40::kFurniture, 1);
    builder.box(paint, low, high);
    home.things.push_back({object, "cube", "red", "", 1, low, high});
  }
  return home;
}

graph::NavGraph graph_at(const std::vector<Vec3d>& points) {
  return graph::NavGraph(graph::testing::connectivity("scan", points, {}));
}

TEST(ThingsInView, MeasureHowMuchIsSeenAndWhere) {
  const Home home = two_cubes();
  const auto tracer = testing::tracer_of(home);
  const ThingsInView sights(home, *tracer, graph_at({{0, 0, 1.5}}), 100000);
  ASSERT_EQ(sights.at(ViewpointIndex(0)).size(), 1U);  // the other is hidden
  const ThingInView& sight = sights.at(ViewpointIndex(0))[0];
  EXPECT_EQ(sight.thing, 0U);
  // A heading of east; of 100,000 directions some 160 meet the cube, which is 8 degrees wide.
  EXPECT_NEAR(sight.heading, kPi / 2, 0.01);
  EXPECT_NEAR(sight.elevation, 0, 0.01);
  EXPECT_NEAR(sight.distance, 2.8, 0.02);
  // The solid angle of a square of side a at distance d: 4 asin(a^2 / (a^2 + 4 d^2)).
  const double solid = 4 * std::asin(0.16 / (0.16 + 4 * 2.8 * 2.8));
  EXPECT_NEAR(sight.share, solid / (4 * kPi), 0.05 * solid / (4 * kPi));
}

TEST(ThingsInView, PutLargestFirstAndDoNotDependOnThreads) {
  const Home home = testing::small_home();
  const auto tracer = testing::tracer_of(home);
  const graph::NavGraph graph = testing::small_graph(*tracer);
  const ThingsInView one(home, *tracer, graph, 4096, 1), two(home, *tracer, graph, 4096, 2);
  std::size_t seen = 0;
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const auto a = one.at(ViewpointIndex(i)), b = two.at(ViewpointIndex(i));
    ASSERT_EQ(a.size(), b.size());
    seen += a.size();
    EXPECT_TRUE(std::ranges::is_sorted(a, std::ranges::greater(), &ThingInView::share));
    for (std::size_t k = 0; k < a.size(); ++k) {
      EXPECT_EQ(a[k].thing, b[k].thing);
      EXPECT_EQ(a[k].heading, b[k].heading);
      EXPECT_GE(a[k].share, 3.0 / 4096);
    }
  }
  EXPECT_GT(seen, graph.size());
}

TEST(ThingsInView, KnowTheRoom) {
  const Home home = two_cubes();
  const auto tracer = testing::tracer_of(home);
  const ThingsInView sights(
      home, *tracer,
      graph_at({{0, 0, 1.5}, {2, 0, 1.5}, {1.05, 0, 1.5}, {1.15, 0, 1.5}, {0, 4, 1.5}}));
  EXPECT_EQ(sights.room(ViewpointIndex(0)), 0U);
  EXPECT_EQ(sights.room(ViewpointIndex(1)), 1U);
  EXPECT_EQ(sights.room(ViewpointIndex(2)), 0U);  // on a threshold
  EXPECT_EQ(sights.room(ViewpointIndex(3)), 1U);
  EXPECT_EQ(sights.room(ViewpointIndex(4)), std::nullopt);
}

TEST(ThingsInView, KnowTheStorey) {
  const Home home = testing::small_home();
  const auto tracer = testing::tracer_of(home);
  const ThingsInView sights(home, *tracer,
                            graph_at({{6, 5, 1.5}, {6, 5, 4.5}, {11, 3.6, 3}, {11, 6.5, 4.5}}));
  EXPECT_EQ(sights.room(ViewpointIndex(0)), 2U);  // living room
  EXPECT_EQ(sights.room(ViewpointIndex(1)), 7U);  // the landing above it
  EXPECT_EQ(sights.room(ViewpointIndex(2)), 5U);  // half-way up: the lower stairs
  EXPECT_EQ(sights.room(ViewpointIndex(3)), 6U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::homes::instructions
