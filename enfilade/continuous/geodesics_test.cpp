#include "enfilade/continuous/geodesics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "tests/support/made_meshes.h"

namespace enfilade::continuous {
namespace EN_UNIT {

using mesh::testing::Maker;

std::shared_ptr<const NavigationMesh> mesh_of(mesh::Mesh made) {
  const mesh::RayTracer tracer(std::make_shared<const mesh::Mesh>(std::move(made)));
  return std::make_shared<const NavigationMesh>(make_floor_polygons(tracer));
}

// A cell of 1.25 cm, in which every rim lies, at each of two walls.
constexpr double kRim = 2 * 0.0125;

double flat_length(Vec3f a, Vec3f b) { return std::hypot(a.x - b.x, a.y - b.y); }

// 8 x 6 m, with a wall of 0.1 m across at x = 4 that leaves 2 m free at the end y = 6.
mesh::Mesh bent_room() {
  return Maker().room(0, 0, 8, 6).box({3.95F, 0, 0}, {4.05F, 4, 2.6F}).mesh;
}

TEST(Geodesics, StraightWhereNothingIsBetween) {
  const Geodesics ways(mesh_of(bent_room()));
  const FloorPoint a = *ways.mesh().nearest({1, 1, 0}), b = *ways.mesh().nearest({2, 5, 0});
  EXPECT_NEAR(ways.distance(a, b), std::sqrt(17.0), 1e-6);
  ASSERT_EQ(ways.path(a, b)->size(), 2U);
  EXPECT_EQ(ways.distance(a, a), 0);
}

TEST(Geodesics, BendsAroundAWall) {
  const Geodesics ways(mesh_of(bent_room()));
  const FloorPoint a = *ways.mesh().nearest({3, 2, 0}), b = *ways.mesh().nearest({5, 2, 0});
  // A body of radius 0.1 m goes round the wall's end at (3.95, 4) and (4.05, 4) in two arcs of that
  // radius, between lines that touch them.
  const double far = std::hypot(0.95, 2), radius = 0.1;
  const double turned = std::atan2(2, 0.95) + std::asin(radius / far);
  const double around = 2 * (std::sqrt(far * far - radius * radius) + radius * turned) + 0.1;
  EXPECT_NEAR(ways.distance(a, b), around, kRim);
  const auto path = ways.path(a, b);
  ASSERT_TRUE(path);
  EXPECT_GE(path->size(), 4U);
  double sum = 0;
  for (std::size_t k = 1; k < path->size(); ++k) sum += flat_length((*path)[k - 1], (*path)[k]);
  EXPECT_NEAR(sum, ways.distance(a, b), 1e-5);
  EXPECT_NEAR(ways.distance(a, b), ways.distance(b, a), 1e-9);
}

TEST(Geodesics, NoWayIsInfinite) {
  mesh::Mesh two = Maker().room(0, 0, 5, 4).mesh;
  append(two, Maker().room(10, 0, 13, 3).mesh);
  const Geodesics ways(mesh_of(two));
  const FloorPoint a = *ways.mesh().nearest({1, 1, 0}), b = *ways.mesh().nearest({11.5F, 1.5F, 0});
  EXPECT_EQ(ways.distance(a, b), std::numeric_limits<double>::infinity());
  EXPECT_FALSE(ways.path(a, b));
  EXPECT_FALSE(ways.field(b).way(a));
  EXPECT_THROW(ways.field(std::span<const FloorPoint>()), ArgumentError);
  EXPECT_THROW(Geodesics(nullptr), ArgumentError);
}

TEST(Geodesics, FieldsSayTheSameAsSearches) {
  const Geodesics ways(mesh_of(mesh::testing::two_storeys().mesh));
  Rng rng(3);
  for (int trial = 0; trial < 40; ++trial) {
    const std::vector<FloorPoint> goals{ways.mesh().random_point(rng),
                                        ways.mesh().random_point(rng)};
    const DistanceField field = ways.field(goals);
    for (int k = 0; k < 25; ++k) {
      const FloorPoint from = ways.mesh().random_point(rng);
      const double least = std::min(ways.distance(from, goals[0]), ways.distance(from, goals[1]));
      const double found = field.distance(from);
      if (std::isinf(least)) {
        EXPECT_TRUE(std::isinf(found));
        continue;
      }
      EXPECT_NEAR(found, least, 1e-6);
      // What is left after the first straight piece.
      const auto way = field.way(from);
      ASSERT_TRUE(way);
      const auto corner = ways.mesh().nearest(way->next, {0.05F, 0.5F});
      ASSERT_TRUE(corner);
      EXPECT_NEAR(length(to_double(way->next) - to_double(from.point)) + field.distance(*corner),
                  least, 0.02);
    }
  }
}

TEST(Geodesics, AreMetric) {
  const Geodesics ways(mesh_of(mesh::testing::two_storeys().mesh));
  Rng rng(11);
  for (int trial = 0; trial < 500; ++trial) {
    const FloorPoint a = ways.mesh().random_point(rng, 0), b = ways.mesh().random_point(rng, 0),
                     c = ways.mesh().random_point(rng, 0);
    const double ab = ways.distance(a, b), bc = ways.distance(b, c), ac = ways.distance(a, c);
    EXPECT_NEAR(ab, ways.distance(b, a), 1e-6);
    EXPECT_GE(ab, length(to_double(a.point) - to_double(b.point)) - 1e-6);
    // Straight lines over a flight of stairs are measured straight, others along its bends: the
    // inequality holds to how far the floor is from straight there.
    EXPECT_LE(ac, ab + bc + 0.05);
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::continuous
