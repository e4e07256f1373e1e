#include "enfilade/continuous/habitat/path_finder.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "enfilade/core/errors.h"
#include "tests/support/flat_floor.h"

namespace enfilade::continuous::habitat {
namespace EN_UNIT {

using testing::flat_floor;

// Lengths of a few float32 differ by less than 1e-5 m, areas of many triangles by less than 1e-3
// m2. Two cells of 5 cm and the body's radius, which is two cells: where a floor that ends at 0
// begins.
constexpr float kRim = 0.15F;
constexpr float kCell = 0.051F;

// A square of 6 m, with a room of 2 m beside it that no body reaches.
PathFinder two_rooms() { return flat_floor({{-3, -3, 3, 3}, {4, -1, 6, 1}}); }
// An L: from (-2, 2) to (2, -2) the way is round the corner near (0, 0).
PathFinder corner() { return flat_floor({{-3, -3, 0, 3}, {0, -3, 3, 0}}); }

float height_of(const PathFinder& floor) { return floor.snap({0, 0, 0}).y; }

TEST(HabitatPathFinder, IslandsAreConnectedParts) {
  const PathFinder floor = two_rooms();
  ASSERT_EQ(floor.islands(), 2U);
  const int square = floor.island({0, 0, 0}), room = floor.island({5, 0, 0});
  EXPECT_NE(square, room);
  EXPECT_EQ(floor.island({0, 10, 0}), -1);
  const float side = 6 - 2 * kRim;
  const auto of = [](int island) { return static_cast<std::size_t>(island); };
  EXPECT_NEAR(floor.island_area(of(square)), side * side, 4 * side * kCell);
  EXPECT_NEAR(floor.area(), floor.island_area(0) + floor.island_area(1), 1e-5);
  EXPECT_NEAR(floor.island_radius(of(square)), side / std::sqrt(2.0F), 2 * kCell);
  EXPECT_EQ(floor.island_radius(Vec3f{0, 0, 0}), floor.island_radius(of(square)));
  EXPECT_EQ(floor.island_radius(Vec3f{0, 10, 0}), 0);
}

TEST(HabitatPathFinder, PointsAreProjectedWithinReach) {
  const PathFinder floor = two_rooms();
  const Vec3f aside = floor.snap({-4.5F, 0, 1});
  EXPECT_NEAR(aside.x, -3 + kRim, kCell);
  EXPECT_EQ(aside.z, 1);
  EXPECT_TRUE(std::isnan(floor.snap({-5.2F, 0, 1}).x));  // farther than 2 m from the rim
  EXPECT_FALSE(std::isnan(floor.snap({0, 3.9F, 0}).x));
  EXPECT_TRUE(std::isnan(floor.snap({0, 4.5F, 0}).x));
  // Nearest to the square, but the other room is asked for; afterwards both are there again.
  const int room = floor.island({5, 0, 0});
  EXPECT_NEAR(floor.snap({3.1F, 0, 0}, room).x, 4 + kRim, kCell);
  EXPECT_NEAR(floor.snap({3.1F, 0, 0}).x, 3 - kRim, kCell);
}

TEST(HabitatPathFinder, NavigablePointsAreOnTheFloor) {
  const PathFinder floor = two_rooms();
  const float y = height_of(floor);
  EXPECT_TRUE(floor.is_navigable({0, y, 0}));
  EXPECT_TRUE(floor.is_navigable({0, y + 0.4F, 0}));
  EXPECT_FALSE(floor.is_navigable({0, y + 0.6F, 0}));
  EXPECT_FALSE(floor.is_navigable({0, y + 0.2F, 0}, 0.1F));
  const float rim = floor.snap({-4, 0, 0}).x;
  EXPECT_TRUE(floor.is_navigable({rim - 0.009F, y, 0}));
  EXPECT_FALSE(floor.is_navigable({rim - 0.011F, y, 0}));
}

TEST(HabitatPathFinder, ObstaclesAreWalls) {
  const PathFinder floor = two_rooms();
  const float rim = floor.snap({-4, 0, 0}).x;
  const Obstacle near = floor.closest_obstacle({-2, 0, 0.5F});
  EXPECT_NEAR(near.distance, -2 - rim, 1e-5);
  EXPECT_NEAR(near.position.x, rim, 1e-5);
  EXPECT_NEAR(near.normal.x, 1, 1e-5);
  EXPECT_EQ(floor.closest_obstacle({0, 0, 0}, 0.5F).distance, 0.5F);  // none within it
  EXPECT_TRUE(std::isinf(floor.closest_obstacle({0, 10, 0}).distance));
}

TEST(HabitatPathFinder, PathsGoRoundCorners) {
  const PathFinder floor = corner();
  const Path straight = floor.path({-2, 0, -2}, {2, 0, -2});
  ASSERT_EQ(straight.points.size(), 2U);
  EXPECT_NEAR(straight.length, 4, 1e-5);
  const Path round = floor.path({-2, 0, 2}, {2, 0, -2});
  ASSERT_GE(round.points.size(), 3U);  // Recast may cut the corner: two points then
  EXPECT_NEAR(round.points[1].x, -kRim, 3 * kCell);
  EXPECT_NEAR(round.points[1].z, -kRim, 3 * kCell);
  const float leg = std::hypot(2 - kRim, 2 + kRim);
  EXPECT_NEAR(round.length, 2 * leg, 0.1);
  const Path nothing = floor.path({1, 0, -1}, {1, 0, -1});
  EXPECT_EQ(nothing.points.size(), 2U);
  EXPECT_EQ(nothing.length, 0);
}

TEST(HabitatPathFinder, NoPathLeadsToAnotherIsland) {
  const PathFinder floor = two_rooms();
  EXPECT_FALSE(floor.path({0, 0, 0}, {5, 0, 0}).found());
  EXPECT_FALSE(floor.path({0, 0, 0}, {0, 20, 0}).found());
  EXPECT_TRUE(std::isinf(floor.path({0, 0, 0}, {5, 0, 0}).length));
}

TEST(HabitatPathFinder, TheNearestGoalIsByPath) {
  const PathFinder floor = corner();
  const Vec3f start{-0.5F, 0, 2.5F};
  // The second is nearer in a straight line, but round the corner.
  const std::vector<Vec3f> goals{{-2.5F, 0, -1.5F}, {2.5F, 0, -0.3F}, {9, 0, 9}};
  GoalBounds bounds;
  const GoalPath first = floor.path(start, goals, bounds);
  EXPECT_EQ(first.goal, 0);
  EXPECT_EQ(first.path.length, floor.path(start, goals[0]).length);
  const GoalPath second = floor.path({1, 0, -1}, goals, bounds);  // with bounds of the first
  EXPECT_EQ(second.goal, 1);
  EXPECT_EQ(second.path.length, floor.path({1, 0, -1}, goals[1]).length);
  GoalBounds others;
  EXPECT_EQ(floor.path(start, std::vector<Vec3f>{{9, 0, 9}}, others).goal, -1);
}

TEST(HabitatPathFinder, RandomPointsAreUniformAndRepeated) {
  const PathFinder floor = two_rooms();
  const int square = floor.island({0, 0, 0});
  const auto draw = [&](std::uint32_t seed) {
    PathFinder::seed(seed);
    std::vector<Vec3f> out;
    for (int k = 0; k < 2000; ++k) out.push_back(floor.random_point(10, square));
    return out;
  };
  const std::vector<Vec3f> points = draw(1);
  EXPECT_EQ(points, draw(1));
  EXPECT_NE(points, draw(2));
  Vec3f sum;
  for (const Vec3f p : points) {
    ASSERT_EQ(floor.island(p), square);
    sum += p;
  }
  // The mean of 2,000 of a standard deviation of 1.65 m: five times 0.037 m.
  EXPECT_NEAR(sum.x / 2000, 0, 0.19);
  EXPECT_NEAR(sum.z / 2000, 0, 0.19);
  int in_room = 0;
  for (int k = 0; k < 2000; ++k) in_room += floor.random_point().x > 3.5F ? 1 : 0;
  // Its share of the area is 8.2 %: 164 of 2,000, with a standard deviation of 12.
  EXPECT_NEAR(in_room, 2000 * (floor.area() - 32.5) / floor.area(), 65);
}

TEST(HabitatPathFinder, RandomPointsNearAreInTheCircle) {
  const PathFinder floor = two_rooms();
  PathFinder::seed(3);
  const Vec3f centre{2.5F, 9, 2.5F};  // the height does not count
  for (int k = 0; k < 50; ++k) {
    const Vec3f p = floor.random_point_near(centre, 1, 1000);
    ASSERT_LT(std::hypot(p.x - centre.x, p.z - centre.z), 1);
  }
  EXPECT_TRUE(std::isnan(floor.random_point_near({20, 0, 20}, 1).x));
}

TEST(HabitatPathFinder, StepsSlideOrStop) {
  for (const Navigation navigation : {Navigation::kLatest, Navigation::kV033}) {
    const PathFinder floor(two_rooms().mesh(), navigation);
    const float y = height_of(floor), wall = floor.snap({-4, 0, 0}).x;
    const Vec3f start{wall + 0.1F, y, 0};
    EXPECT_EQ(floor.step(start, {start.x, y, 0.25F}, Moves::kStop), (Vec3f{start.x, y, 0.25F}));
    const Vec3f at_wall{wall - 0.3F, y, 0.4F};
    const Vec3f slid = floor.step(start, at_wall, Moves::kSlide);
    EXPECT_NEAR(slid.x, wall, 1e-5);
    EXPECT_NEAR(slid.z, 0.4F, 1e-5);
    const Vec3f stopped = floor.step(start, at_wall, Moves::kStop);
    EXPECT_NEAR(stopped.x, wall, 1e-5);
    EXPECT_NEAR(stopped.z, 0.1F, 1e-5);  // a quarter of the way
    const Vec3f start_of_room{2.8F, y, 0};
    EXPECT_EQ(floor.step(start_of_room, {5, y, 0}, Moves::kSlide), start_of_room);
    EXPECT_EQ(floor.step(start_of_room, {5, y, 0}, Moves::kStop), start_of_room);
    // From above the floor: it begins where that is projected.
    EXPECT_EQ(floor.step({0, y + 1, 0}, {0.25F, y + 1, 0}, Moves::kSlide), (Vec3f{0.25F, y, 0}));
  }
}

TEST(HabitatPathFinder, TrianglesCoverTheFloor) {
  const PathFinder floor = two_rooms();
  const auto area = [](const std::vector<Vec3f>& corners) {
    float sum = 0;
    for (std::size_t k = 0; k + 2 < corners.size(); k += 3) {
      sum += length(cross(corners[k + 1] - corners[k], corners[k + 2] - corners[k])) / 2;
    }
    return sum;
  };
  EXPECT_NEAR(area(floor.vertices()), floor.area(), 1e-3);
  EXPECT_NEAR(area(floor.vertices(1)), floor.island_area(1), 1e-3);
}

TEST(HabitatPathFinder, MapsAreSeenFromAbove) {
  const PathFinder floor = two_rooms();
  const auto map = floor.topdown(0.1F, height_of(floor));
  EXPECT_EQ(map.columns, 90U);
  EXPECT_EQ(map.rows, 60U);
  float covered = 0;
  for (const std::uint8_t v : map.values) covered += v;
  EXPECT_NEAR(covered / 100, floor.area(), 1.5);  // pixels at the rims
  const auto islands = floor.topdown_islands(0.1F, height_of(floor));
  for (std::size_t k = 0; k < map.values.size(); ++k) {
    ASSERT_EQ(islands.values[k] >= 0, map.values[k] == 1);
  }
  EXPECT_EQ(islands.values[30 * 90 + 30], floor.island({0, 0, 0}));
  EXPECT_THROW(floor.topdown(0, 0), ArgumentError);
  EXPECT_THROW(floor.topdown(1e-5F, 0), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::continuous::habitat
