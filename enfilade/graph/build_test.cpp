#include "enfilade/graph/build.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>

#include "enfilade/core/rng.h"
#include "enfilade/graph/check.h"
#include "enfilade/graph/nav_graph.h"
#include "tests/support/made_meshes.h"

namespace enfilade::graph {
namespace EN_UNIT {

using mesh::RayTracer;
using mesh::WalkableFloor;
using mesh::testing::Maker;

// A building ready for questions.
struct Building {
  explicit Building(const Maker& maker)
      : tracer(std::make_shared<const mesh::Mesh>(maker.mesh)), floor(maker.mesh) {}

  scan::Connectivity connect(const std::vector<PlacedViewpoint>& viewpoints,
                             const EdgeOptions& options = {}, int threads = 0) const {
    return connect_viewpoints(tracer, floor, viewpoints, "made", options, threads);
  }
  std::vector<PlacedViewpoint> place(const ViewpointOptions& options = {}) const {
    return place_viewpoints(tracer, floor, options);
  }

  RayTracer tracer;
  WalkableFloor floor;
};

PlacedViewpoint at(double x, double y, double floor = 0) { return {{x, y, floor + 1.5}, 1.5}; }

bool has_edge(const Building& building, PlacedViewpoint a, PlacedViewpoint b,
              const EdgeOptions& options = {}) {
  const scan::Connectivity c = building.connect({a, b}, options);
  EXPECT_EQ(c.entries[0].unobstructed.empty(), c.entries[1].unobstructed.empty());
  return !c.entries[0].unobstructed.empty();
}

bool sees(const Building& building, PlacedViewpoint a, PlacedViewpoint b) {
  return !building.connect({a, b}).entries[0].visible.empty();
}

TEST(ConnectViewpoints, RoomLetsThroughUpToTheLimit) {
  const Building room(Maker().room(0, 0, 9, 4));
  EXPECT_TRUE(has_edge(room, at(1, 2), at(5.9, 2)));
  EXPECT_FALSE(has_edge(room, at(1, 2), at(6.1, 2)));
  EXPECT_TRUE(sees(room, at(1, 2), at(6.1, 2)));
  EdgeOptions longer;
  longer.longest = 6;
  EXPECT_TRUE(has_edge(room, at(1, 2), at(6.1, 2), longer));
}

TEST(ConnectViewpoints, WallsStopAndDoorsLetThrough) {
  const Building rooms(Maker().room(0, 0, 8, 4).wall_with_hole(4, 0, 4, 1.5F, 2.4F));
  EXPECT_TRUE(has_edge(rooms, at(3, 1.95), at(5, 1.95)));
  EXPECT_FALSE(has_edge(rooms, at(3, 3.5), at(5, 3.5)));
  EXPECT_FALSE(sees(rooms, at(3, 3.5), at(5, 3.5)));
  // The eyes meet through the door, the body would touch its frame.
  EXPECT_TRUE(sees(rooms, at(3, 1.6), at(5, 1.6)));
  EXPECT_FALSE(has_edge(rooms, at(3, 1.6), at(5, 1.6)));
}

TEST(ConnectViewpoints, HolesTooNarrowOrTooLowStopBodies) {
  const Building narrow(Maker().room(0, 0, 8, 4).wall_with_hole(4, 0, 4, 1.8F, 2.15F));
  EXPECT_TRUE(sees(narrow, at(3, 1.97), at(5, 1.97)));
  EXPECT_FALSE(has_edge(narrow, at(3, 1.97), at(5, 1.97)));
  EdgeOptions no_floor;
  no_floor.need_floor = false;  // the rays alone say so too
  EXPECT_FALSE(has_edge(narrow, at(3, 1.97), at(5, 1.97), no_floor));
  const Building low(Maker().room(0, 0, 8, 4).wall_with_hole(4, 0, 4, 1.5F, 2.5F, 1.52F));
  EXPECT_TRUE(sees(low, at(3, 2), at(5, 2)));
  EXPECT_FALSE(has_edge(low, at(3, 2), at(5, 2)));
  EXPECT_FALSE(has_edge(low, at(3, 2), at(5, 2), no_floor));
}

TEST(ConnectViewpoints, TablesStopBodiesAndNotEyes) {
  Maker m;
  m.room(0, 0, 6, 4).box({2.5F, 1, 0.7F}, {3.5F, 3, 0.74F});
  const Building room(m);
  EXPECT_TRUE(sees(room, at(1, 2), at(5, 2)));
  EXPECT_FALSE(has_edge(room, at(1, 2), at(5, 2)));
  EXPECT_TRUE(has_edge(room, at(1, 3.5), at(5, 3.5)));
}

TEST(ConnectViewpoints, RailingsAndGapsInTheFloorStopBodies) {
  Maker gap;
  gap.level(0, 0, 2, 4, 0).level(3, 0, 5, 4, 0);
  const Building floors(gap);
  EXPECT_TRUE(sees(floors, at(1, 2), at(4, 2)));
  EXPECT_FALSE(has_edge(floors, at(1, 2), at(4, 2)));
  EdgeOptions flying;
  flying.need_floor = false;
  EXPECT_TRUE(has_edge(floors, at(1, 2), at(4, 2), flying));
}

TEST(ConnectViewpoints, GlassStopsAsAnySurface) {
  Maker m;
  m.room(0, 0, 8, 4).quad({4, 0, 0}, {4, 4, 0}, {4, 4, 2.6F}, {4, 0, 2.6F});
  EXPECT_FALSE(has_edge(Building(m), at(3, 2), at(5, 2)));
}

TEST(ConnectViewpoints, StairsAreClimbed) {
  const Building house(mesh::testing::two_storeys());
  const double rise = 3.0 / 16, tread = 4.1 / 16;
  const auto step = [&](int k) { return at(0.9 + (k + 0.5) * tread, 0.5, (k + 1) * rise); };
  EXPECT_TRUE(has_edge(house, at(0.5, 0.5), step(7)));
  EXPECT_TRUE(has_edge(house, step(3), step(14)));
  EXPECT_TRUE(has_edge(house, step(8), at(5.5, 0.5, 3)));
  // Over the railing, and through the floor.
  EXPECT_FALSE(has_edge(house, step(11), at(3.9, 2, 3)));
  EXPECT_FALSE(has_edge(house, at(3, 3), at(3.5, 3, 3)));
}

TEST(ConnectViewpoints, WritesMatterportsFormat) {
  const Building room(Maker().room(0, 0, 5, 4));
  const scan::Connectivity c = room.connect({at(1, 2), at(4, 2), at(1, 2)});
  EXPECT_EQ(c.scan, "made");
  std::set<std::string> ids;
  for (const scan::ConnectivityEntry& e : c.entries) {
    EXPECT_THAT(e.id, ::testing::MatchesRegex("[0-9a-f]{32}"));
    ids.insert(e.id);
    EXPECT_TRUE(e.included);
    EXPECT_DOUBLE_EQ(e.height, 1.5);
  }
  EXPECT_EQ(ids.size(), 3U);  // of equal places too
  EXPECT_EQ(c.entries[1].position(), (Vec3d{4, 2, 1.5}));
  // Columns: right +x, down -z, look +y.
  const std::array<double, 16> pose{1, 0, 0, 4, 0, 0, 1, 2, 0, -1, 0, 1.5, 0, 0, 0, 1};
  EXPECT_EQ(c.entries[1].pose, pose);
  const auto again = scan::parse_connectivity(scan::to_json(c), "made", "again");
  EXPECT_EQ(again.entries[0].unobstructed, c.entries[0].unobstructed);
  // Other scans have other ids.
  const auto other = connect_viewpoints(room.tracer, room.floor, {at(1, 2)}, "other");
  EXPECT_NE(other.entries[0].id, c.entries[0].id);
}

TEST(ConnectViewpoints, ThreadsMakeNoDifferenceAndProgressEnds) {
  const Building house(mesh::testing::two_storeys());
  const auto viewpoints = house.place();
  std::vector<std::size_t> steps;
  const auto many =
      connect_viewpoints(house.tracer, house.floor, viewpoints, "made", {}, 7,
                         [&](std::size_t done, std::size_t) { steps.push_back(done); });
  EXPECT_EQ(scan::to_json(many), scan::to_json(house.connect(viewpoints, {}, 1)));
  EXPECT_TRUE(std::ranges::is_sorted(steps));
  EXPECT_EQ(steps.back(), viewpoints.size());
}

TEST(ConnectViewpoints, RefusesOptionsOutOfRange) {
  const Building room(Maker().room(0, 0, 5, 4));
  EdgeOptions options;
  options.longest = std::nan("");
  EXPECT_THROW(room.connect({}, options), ArgumentError);
  options = {};
  options.rows = 0;
  EXPECT_THROW(room.connect({}, options), ArgumentError);
  options = {};
  options.highest = 0.1;  // below lowest
  EXPECT_THROW(room.connect({}, options), ArgumentError);
  EXPECT_TRUE(room.connect({}).entries.empty());
}

bool one_piece(const scan::Connectivity& c) {
  const NavGraph graph(c);
  for (std::size_t v = 1; v < graph.size(); ++v) {
    if (std::isinf(graph.distance(ViewpointIndex(std::size_t{0}), ViewpointIndex(v)))) return false;
  }
  return true;
}

bool any_within(const std::vector<PlacedViewpoint>& viewpoints, Vec3d low, Vec3d high) {
  return std::ranges::any_of(viewpoints, [&](const PlacedViewpoint& v) {
    return v.eye.x >= low.x && v.eye.x <= high.x && v.eye.y >= low.y && v.eye.y <= high.y &&
           v.eye.z >= low.z && v.eye.z <= high.z;
  });
}

TEST(PlaceViewpoints, EveryRoomHasOneAndAllHangTogether) {
  // A hall, and three rooms of 4, 4 and 1.5 m2 behind doors of 0.8 m.
  Maker m;
  m.room(0, 0, 8, 4).box({0, 2, 0}, {0.6F, 2.1F, 2.6F}).box({1.4F, 2, 0}, {2.6F, 2.1F, 2.6F});
  m.box({3.4F, 2, 0}, {4.6F, 2.1F, 2.6F}).box({5.4F, 2, 0}, {8, 2.1F, 2.6F});
  m.box({2, 2, 0}, {2.1F, 4, 2.6F}).box({4, 2, 0}, {4.1F, 4, 2.6F});
  m.box({5.4F, 2, 0}, {5.5F, 4, 2.6F}).box({4, 3.3F, 0}, {5.5F, 3.4F, 2.6F});
  const Building flat(m);
  const auto viewpoints = flat.place();
  EXPECT_TRUE(any_within(viewpoints, {0, 2.1, 0}, {2, 4, 3}));
  EXPECT_TRUE(any_within(viewpoints, {2.1, 2.1, 0}, {4, 4, 3}));
  EXPECT_TRUE(any_within(viewpoints, {4.1, 2.1, 0}, {5.4, 3.3, 3}));
  EXPECT_TRUE(any_within(viewpoints, {0, 0, 0}, {8, 2, 3}));
  EXPECT_TRUE(one_piece(flat.connect(viewpoints)));
}

TEST(PlaceViewpoints, StairsAreClimbedStepByStep) {
  const Building house(mesh::testing::two_storeys());
  const auto viewpoints = house.place();
  EXPECT_TRUE(any_within(viewpoints, {0, 0, 1}, {6, 4, 2}));
  EXPECT_TRUE(any_within(viewpoints, {0, 0, 4.4}, {6, 4, 5}));
  EXPECT_TRUE(any_within(viewpoints, {0.9, 0, 1.6}, {5, 1, 4.4}));  // on the flight
  const auto graph = house.connect(viewpoints);
  EXPECT_TRUE(one_piece(graph));
  EXPECT_TRUE(check_graph(graph).empty());
}

TEST(PlaceViewpoints, StandOnTheFloorClearOfWallsAtEyeHeight) {
  const Building room(Maker().room(0, 0, 7, 6));
  for (const PlacedViewpoint& v : room.place()) {
    EXPECT_NEAR(v.eye.z, 1.5, 1e-6);
    EXPECT_NEAR(v.height, 1.5, 1e-6);
    EXPECT_GT(v.eye.x, 0.5);
    EXPECT_LT(v.eye.x, 6.5);
    EXPECT_GT(v.eye.y, 0.5);
    EXPECT_LT(v.eye.y, 5.5);
  }
}

TEST(PlaceViewpoints, EyesStayBelowLowCeilings) {
  const Building room(Maker().room(0, 0, 5, 4, 0, 1.8F));
  ViewpointOptions tall;
  tall.eye_height = 2.2;
  for (const PlacedViewpoint& v : room.place(tall)) EXPECT_NEAR(v.height, 1.7, 1e-5);
}

TEST(PlaceViewpoints, EachPlaceIsNearOne) {
  const Building hall(Maker().room(0, 0, 12, 9));
  const auto viewpoints = hall.place();
  for (const mesh::FloorCell& cell : hall.floor.cells()) {
    double nearest = 1e9;
    for (const PlacedViewpoint& v : viewpoints) {
      nearest = std::min(nearest, std::hypot(v.eye.x - cell.position.x, v.eye.y - cell.position.y));
    }
    // The separation on foot to a candidate, one of which is in each square of 0.2 m.
    ASSERT_LT(nearest, 2.25);
  }
}

TEST(PlaceViewpoints, SeparationSpreadsThem) {
  const Building hall(Maker().room(0, 0, 12, 9));
  const auto count = [&](double separation) {
    ViewpointOptions options;
    options.separation = separation;
    return static_cast<double>(hall.place(options).size());
  };
  // As many as fit goes with the square; rims make it less.
  EXPECT_GT(count(1.5), 1.6 * count(2.25));
  EXPECT_GT(count(2.25), 1.6 * count(4));
}

TEST(PlaceViewpoints, SameSeedSamePlaces) {
  const Building house(mesh::testing::two_storeys());
  const auto eyes = [&](std::uint64_t seed) {
    ViewpointOptions options;
    options.seed = seed;
    std::vector<Vec3d> found;
    for (const PlacedViewpoint& v : house.place(options)) found.push_back(v.eye);
    return found;
  };
  EXPECT_EQ(eyes(1), eyes(1));
  EXPECT_NE(eyes(1), eyes(2));
}

TEST(PlaceViewpoints, TableTopsAndMeadowsHaveNone) {
  Maker m;
  m.room(0, 0, 7, 6).level(-10, -10, 16, 16, -0.4F);
  m.box({2, 2, 0}, {4, 4.2F, 0.5F});  // a bed: walkable by itself, too small for two viewpoints
  for (const PlacedViewpoint& v : Building(m).place()) EXPECT_NEAR(v.eye.z, 1.5, 1e-6);
}

// Rooms in a grid of random widths; walls between them have doors or none; crates stand about.
Maker random_rooms(Rng& rng) {
  Maker m;
  std::vector<float> xs{0}, ys{0};
  for (int i = 0; i < 3; ++i) {
    xs.push_back(xs.back() + 2.2F + static_cast<float>(2.5 * rng.uniform()));
    ys.push_back(ys.back() + 2.2F + static_cast<float>(2.5 * rng.uniform()));
  }
  m.room(0, 0, xs.back(), ys.back());
  constexpr float kTop = 2.6F;
  const auto wall = [&](float x0, float y0, float x1, float y1) {
    m.box({x0 - 0.05F, y0 - 0.05F, 0}, {x1 + 0.05F, y1 + 0.05F, kTop});
  };
  for (std::size_t i = 1; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const auto door = static_cast<float>(0.4 + 0.8 * rng.uniform());
      const float wide = rng.below(4) == 0 ? 0 : 0.85F;
      wall(xs[i], ys[j], xs[i], ys[j] + door);
      wall(xs[i], ys[j] + door + wide, xs[i], ys[j + 1]);
      wall(xs[j], ys[i], xs[j] + door, ys[i]);
      wall(xs[j] + door + wide, ys[i], xs[j + 1], ys[i]);
    }
  }
  for (int k = 0; k < 6; ++k) {
    const auto x = static_cast<float>(rng.uniform()) * xs.back();
    const auto y = static_cast<float>(rng.uniform()) * ys.back();
    m.box({x, y, 0}, {x + 0.7F, y + 0.5F, 0.8F});
  }
  return m;
}

TEST(BuildGraph, NoTwoViewpointsStandInOnePlace) {
  // Half of the spacing on foot, which is 0.66 separations.
  const double least = 0.5 * 0.66 * ViewpointOptions().separation;
  std::size_t near = 0, viewpoints = 0;
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Building building(random_rooms(rng));
    const auto connectivity = building.connect(building.place());
    const NavGraph graph(connectivity);
    viewpoints += graph.size();
    for (std::size_t i = 0; i < graph.size(); ++i) {
      for (const ViewpointIndex j : connectivity.entries[i].visible) {
        const ViewpointIndex v(i);
        const auto apart = length(graph.position(v) - graph.position(j));
        EXPECT_GT(apart, 0.25);
        if (j.at() > i && apart < least) ++near;
      }
    }
  }
  // Each of the few is the way to somewhere, or the only one in its room.
  EXPECT_LT(static_cast<double>(near), 0.02 * static_cast<double>(viewpoints));
}

TEST(BuildGraph, HangsTogetherWhereTheFloorDoes) {
  for (std::uint64_t seed = 0; seed < 25; ++seed) {
    SCOPED_TRACE(seed);
    Rng rng(seed);
    const Building building(random_rooms(rng));
    const auto viewpoints = building.place();
    const NavGraph graph(building.connect(viewpoints));
    std::vector<std::uint32_t> area;
    for (const PlacedViewpoint& v : viewpoints) {
      area.push_back(building.floor.cells()[building.floor.below(to_float(v.eye)).value()].area);
    }
    for (std::size_t i = 0; i < viewpoints.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        const bool joined = std::isfinite(graph.distance(ViewpointIndex(i), ViewpointIndex(j)));
        EXPECT_EQ(joined, area[i] == area[j]) << i << " " << j;
      }
      for (const Edge& edge : graph.edges(ViewpointIndex(i))) {
        EXPECT_LE(edge.length, 5);
        EXPECT_TRUE(graph.edge(edge.target, ViewpointIndex(i)));
      }
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::graph
