#include <gtest/gtest.h>
#include <cmath>
#include <numbers>

#include "enfilade/homes/looks/architecture.h"
#include "tests/support/home_passage.h"

namespace enfilade::homes {
namespace EN_UNIT {

constexpr double kWidth = 0.4, kLowest = 0.35, kHighest = 1.55;

bool is_free(const Home& home, Vec3d a, Vec3d b, double slack = 0) {
  return tests::passage_is_free(home, a, b, kWidth, kLowest, kHighest, slack);
}

/// Two rooms side by side, 4 by 4 m, with a doorway 1 m wide between them.
Home two_rooms() {
  Home home;
  home.plan.storeys = {{0, 3}};
  home.plan.rooms = {{'l', "a", 0, {0, 0, 4, 4}, 2.6}, {'k', "b", 0, {4.12, 0, 8.12, 4}, 2.6}};
  Opening o;
  o.room0 = 0;
  o.room1 = 1;
  o.along_x = false;
  o.wall = 4.06;
  o.from = 1.5;
  o.to = 2.5;
  home.plan.openings = {o};
  home.obstacles = {{4.06, 0.75, 0.06, 0.75, 0, 0, 2.6},
                    {4.06, 3.25, 0.06, 0.75, 0, 0, 2.6},
                    {4.06, 2, 0.06, 0.5, 0, 2.1, 2.6}};
  return home;
}

TEST(Passage, LeadsThroughDoorsNotWalls) {
  const Home home = two_rooms();
  EXPECT_TRUE(is_free(home, {2, 2, 0}, {6, 2, 0}));
  EXPECT_TRUE(is_free(home, {6, 2, 0}, {2, 2, 0}));
  EXPECT_FALSE(is_free(home, {2, 0.7, 0}, {6, 0.7, 0}));
  // 0.2 m on either side of the middle: it just gets past the post at 1.5.
  EXPECT_TRUE(is_free(home, {2, 1.71, 0}, {6, 1.71, 0}));
  EXPECT_FALSE(is_free(home, {2, 1.69, 0}, {6, 1.69, 0}));
  EXPECT_TRUE(is_free(home, {2, 1.69, 0}, {6, 1.69, 0}, 0.02));
  EXPECT_FALSE(is_free(home, {2, 1.71, 0}, {6, 1.71, 0}, -0.02));
}

TEST(Passage, NeedsFloorAllTheWay) {
  Home home = two_rooms();
  home.obstacles.clear();
  EXPECT_FALSE(is_free(home, {2, 0.7, 0}, {6, 0.7, 0}));  // no wall, but no floor in its place
  EXPECT_FALSE(is_free(home, {2, 2, 0}, {9, 2, 0}));      // out of the house
  home.plan.openings[0].kind = OpeningKind::kWindow;
  EXPECT_FALSE(is_free(home, {2, 2, 0}, {6, 2, 0}));
}

TEST(Passage, MeetsTurnedThingsAtBodyHeightOnly) {
  Home home = two_rooms();
  home.plan.openings.clear();
  // A beam 2 m long and 10 cm thick, turned by 45 degrees about (2, 2): at y = 1.5 it is at x
  // = 1.5.
  home.obstacles = {{2, 2, 1, 0.05, std::numbers::pi / 4, 0, 1}};
  EXPECT_FALSE(is_free(home, {0.5, 1.5, 0}, {3.5, 1.5, 0}));
  EXPECT_TRUE(is_free(home, {0.5, 2.5, 0}, {1.5, 3.5, 0}));  // beside it, in its direction
  EXPECT_TRUE(is_free(home, {0.5, 3.1, 0}, {3.5, 3.1, 0}));
  home.obstacles[0].z1 = 0.34;  // below the body
  EXPECT_TRUE(is_free(home, {0.5, 1.5, 0}, {3.5, 1.5, 0}));
  home.obstacles[0].z0 = 1.56;  // above it
  home.obstacles[0].z1 = 2;
  EXPECT_TRUE(is_free(home, {0.5, 1.5, 0}, {3.5, 1.5, 0}));
  home.obstacles[0].z0 = 1.54;
  EXPECT_FALSE(is_free(home, {0.5, 1.5, 0}, {3.5, 1.5, 0}));
}

Vec3d on_flight(const Plan& plan, const Stairs& s, double share) {
  const Rect& f = s.flight;
  const double t = is_high(s.climbs_towards) ? share : 1 - share;
  const bool x = faces_x(s.climbs_towards);
  const double z = plan.storeys[s.storey].floor + share * plan.storeys[s.storey].height;
  return x ? Vec3d{f.x0 + t * f.width(), (f.y0 + f.y1) / 2, z}
           : Vec3d{(f.x0 + f.x1) / 2, f.y0 + t * f.depth(), z};
}

TEST(Passage, ClimbsStairsButDoesNotFallIntoTheirHole) {
  for (std::uint64_t seed = 0; seed < 4; ++seed) {
    Home home;
    home.plan = make_plan({seed, HomeKind::kHouse, 3, 330});
    mesh::MeshBuilder builder(home.mesh);
    looks::build_architecture(home.plan, looks::make_styles(home.plan, builder),
                              {builder, home.obstacles, home.things, home.lights.lamps},
                              home.lights.portals);
    for (const Stairs& s : home.plan.stairs) {
      const Vec3d foot = on_flight(home.plan, s, 0.02), middle = on_flight(home.plan, s, 0.5);
      const Vec3d head = on_flight(home.plan, s, 0.98);
      EXPECT_TRUE(is_free(home, foot, middle)) << seed;
      EXPECT_TRUE(is_free(home, middle, head)) << seed;
      // Level above the flight, where the floor is cut out.
      const double up = home.plan.storeys[s.storey + 1].floor;
      EXPECT_FALSE(is_free(home, {foot.x, foot.y, up}, {head.x, head.y, up})) << seed;
      // On the ground below the steps.
      const double down = home.plan.storeys[s.storey].floor;
      EXPECT_FALSE(is_free(home, {foot.x, foot.y, down}, {head.x, head.y, down})) << seed;
    }
  }
}

TEST(Passage, EveryDoorOfABareHomeIsPassable) {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    Home home;
    home.plan = make_plan({seed, {}, {}, 0});
    mesh::MeshBuilder builder(home.mesh);
    looks::build_architecture(home.plan, looks::make_styles(home.plan, builder),
                              {builder, home.obstacles, home.things, home.lights.lamps},
                              home.lights.portals);
    for (const Opening& o : home.plan.openings) {
      const double z = home.plan.storeys[home.plan.rooms[o.room0].storey].floor;
      const double u = (o.from + o.to) / 2;
      const auto at = [&](double n) { return o.along_x ? Vec3d{u, n, z} : Vec3d{n, u, z}; };
      EXPECT_EQ(is_free(home, at(o.wall - 0.6), at(o.wall + 0.6)), o.room1.has_value())
          << "seed " << seed << " " << home.plan.rooms[o.room0].name << " wall " << o.wall;
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::homes
