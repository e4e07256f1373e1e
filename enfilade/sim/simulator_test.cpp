#include "enfilade/sim/simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "tests/support/graphs.h"

namespace enfilade::sim {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr ViewpointIndex v(std::size_t i) { return ViewpointIndex(i); }

std::shared_ptr<const graph::GraphSet> set_of(const scan::Connectivity& connectivity) {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(connectivity);
  return graph::GraphSet::of(std::move(graphs));
}

// Viewpoint 0 in the middle, neighbours at the given points around it.
std::shared_ptr<const graph::GraphSet> star(std::vector<Vec3d> points) {
  std::vector<std::pair<int, int>> edges;
  points.insert(points.begin(), Vec3d{0, 0, 0});
  for (std::size_t i = 1; i < points.size(); ++i) edges.emplace_back(0, static_cast<int>(i));
  return set_of(graph::testing::connectivity("star", points, edges));
}

EpisodeStart at(std::size_t viewpoint, double heading = 0, double elevation = 0) {
  return {{ScanIndex(0), v(viewpoint)}, Radians(heading), Radians(elevation)};
}

// A simulator and its output, with short names for what tests look at.
struct Walker {
  Walker(std::shared_ptr<const graph::GraphSet> graphs, const SimulatorConfig& config)
      : simulator(std::move(graphs), config),
        buffer(config.batch_size, config.max_navigable),
        out(buffer.spans()) {}

  void start(const EpisodeStart& start) { simulator.new_episodes({&start, 1}, out); }
  void act(const Action& action) { simulator.step({&action, 1}, out); }
  void turn(double right, double up = 0) { act({0, Radians(right), Radians(up)}); }

  std::vector<ViewpointIndex> list(std::size_t agent = 0) const {
    const auto row =
        out.navigable_viewpoint.subspan(agent * out.max_navigable(), out.navigable_count[agent]);
    return {row.begin(), row.end()};
  }

  Simulator simulator;
  StateBuffer buffer;
  StateSpans out;
};

SimulatorConfig unrestricted() {
  SimulatorConfig config;
  config.navigation = Navigation::kUnrestricted;
  return config;
}

TEST(Simulator, WalksRoundASquare) {
  // Corners (0,0) (2,0) (2,2) (0,2); from 0 looking north, 3 is ahead and 1 is to the right.
  Walker w(set_of(graph::testing::square()), SimulatorConfig::room_to_room());
  w.start(at(0));
  EXPECT_EQ(w.out.viewpoint[0], v(0));
  EXPECT_THAT(w.list(), ElementsAre(v(0), v(3)));
  EXPECT_NEAR(w.out.navigable_rel_heading[1], 0, 1e-16);  // the cosine of a rounded pi/2
  EXPECT_EQ(w.out.navigable_distance[1], 2);
  for (int i = 0; i < 3; ++i) w.turn(1);
  EXPECT_THAT(w.list(), ElementsAre(v(0), v(1)));
  EXPECT_NEAR(w.out.navigable_rel_heading[1], 0, 1e-7);  // single precision
  w.act({1, Radians(-1), Radians(0)});                   // to 1, then one view left of east
  EXPECT_EQ(w.out.viewpoint[0], v(1));
  EXPECT_NEAR(to_degrees(Radians(w.out.heading[0])), 60, 1e-12);
  EXPECT_EQ(w.out.view_index[0], 12U + 2U);
  EXPECT_EQ(w.out.step[0], 4U);
  EXPECT_THAT(w.list(), ElementsAre(v(1))) << "2 is 60 degrees to the left, outside 80 / 2";
  w.turn(-1);
  EXPECT_THAT(w.list(), ElementsAre(v(1), v(2)));
  EXPECT_NEAR(to_degrees(Radians(w.out.navigable_rel_heading[1])), -30, 1e-5);
}

TEST(Simulator, OwnStateIsWhatACallerWouldGet) {
  const auto graphs = set_of(graph::testing::square());
  Walker brought(graphs, SimulatorConfig::room_to_room());
  Simulator own(graphs, SimulatorConfig::room_to_room());
  const std::array<EpisodeStart, 1> starts{at(0)};
  const std::array<Action, 1> turn{Action{0, Radians(1), {}}};
  brought.start(starts[0]);
  own.new_episodes(starts);
  for (int i = 0; i < 3; ++i) {
    brought.act(turn[0]);
    own.step(turn);
  }
  Simulator moved = std::move(own);
  EXPECT_EQ(moved.state().heading[0], brought.out.heading[0]);
  EXPECT_EQ(moved.state().navigable_count[0], brought.out.navigable_count[0]);
  EXPECT_EQ(moved.state().navigable_viewpoint[1], brought.out.navigable_viewpoint[1]);
  // Memory of the caller's is written alone.
  moved.step(turn, brought.out);
  EXPECT_EQ(moved.state().step[0], 3U);
  EXPECT_EQ(brought.out.step[0], 4U);
}

TEST(Simulator, ListsStartHereAndGoFromTheMiddleOut) {
  Walker w(star({{-1, 0.2, 0}, {0.1, 1, 0}, {1, 0, 0}, {0, -1, 0}, {-0.2, 1, 0.5}}),
           unrestricted());
  w.start(at(0));
  EXPECT_THAT(w.list(), ElementsAre(v(0), v(2), v(5), v(1), v(3), v(4)));
  EXPECT_EQ(w.out.navigable_rel_heading[0], 0);
  EXPECT_EQ(w.out.navigable_rel_elevation[0], 0);
  EXPECT_EQ(w.out.navigable_distance[0], 0);
  EXPECT_NEAR(w.out.navigable_rel_heading[1], std::atan2(0.1, 1), 1e-7);  // single precision
  EXPECT_NEAR(w.out.navigable_rel_elevation[2], std::atan2(0.5, std::hypot(0.2, 1)), 1e-7);
  EXPECT_NEAR(w.out.navigable_distance[2], std::sqrt(0.04 + 1 + 0.25), 1e-7);
}

TEST(Simulator, TiesGoByViewpoint) {
  Walker w(star({{1, 2, 0}, {-1, 2, 0}, {-1, -2, 0}, {1, -2, 0}, {1, 2, 0}}), unrestricted());
  w.start(at(0));
  EXPECT_THAT(w.list(), ElementsAre(v(0), v(1), v(2), v(5), v(3), v(4)));
}

TEST(Simulator, ElevationIsRelativeAndPartOfTheOrder) {
  Walker w(star({{0.3, 1, 0}, {0, 1, 1}}), unrestricted());
  w.start(at(0));
  EXPECT_THAT(w.list(), ElementsAre(v(0), v(1), v(2)));
  w.turn(0, 0.7);
  EXPECT_THAT(w.list(), ElementsAre(v(0), v(2), v(1)));
  EXPECT_NEAR(w.out.navigable_rel_elevation[1], kPi / 4 - 0.7, 1e-15);
}

TEST(Simulator, FieldOfViewIsThePicturesOrMatterSims) {
  // 38 degrees to the right: inside half of 80 degrees, outside half of 75.2.
  const auto graphs = star({{std::sin(0.6632), std::cos(0.6632), 0}});
  SimulatorConfig config;
  Walker picture(graphs, config);
  picture.start(at(0));
  EXPECT_EQ(picture.out.navigable_count[0], 1U);
  config.field_of_view = FieldOfView::kLinear;
  Walker linear(graphs, config);
  linear.start(at(0));
  EXPECT_EQ(linear.out.navigable_count[0], 2U);
}

TEST(Simulator, LinearFieldOfViewTurnsRoundPastAWholeCircle) {
  const auto graphs = star({{std::sin(2.0), std::cos(2.0), 0}, {0, 1, 0}});
  SimulatorConfig config;
  config.field_of_view = FieldOfView::kLinear;
  config.camera = {480, 480, Radians(1)};
  const auto count = [&](std::uint32_t width) {
    config.camera.width = width;
    Walker w(graphs, config);
    w.start(at(0));
    return w.out.navigable_count[0];
  };
  EXPECT_EQ(count(480 * 3), 2U);  // half of 3 rad
  EXPECT_EQ(count(480 * 5), 3U);
  EXPECT_EQ(count(480 * 6), 3U);
  EXPECT_EQ(count(480 * 10), 2U);  // 5 rad, the cosine of 1.28
}

TEST(Simulator, StraightAboveIsListedOnlyWithoutRestriction) {
  const auto graphs = star({{0, 0, 2}, {0, 1, 0}});
  Walker all(graphs, unrestricted());
  all.start(at(0));
  EXPECT_THAT(all.list(), ElementsAre(v(0), v(2), v(1)));
  EXPECT_EQ(all.out.navigable_rel_elevation[2], kPi / 2);
  SimulatorConfig config;
  config.field_of_view = FieldOfView::kLinear;
  config.camera = {628, 100, Radians(1)};  // all around
  Walker seen(graphs, config);
  seen.start(at(0));
  EXPECT_THAT(seen.list(), ElementsAre(v(0), v(2)));
}

TEST(Simulator, ContinuousAnglesWrapAndClamp) {
  SimulatorConfig config;
  config.elevation_limits = {Radians(-0.5), Radians(0.25)};
  Walker w(set_of(graph::testing::square()), config);
  w.start(at(0, -1, 2));
  EXPECT_DOUBLE_EQ(w.out.heading[0], 2 * kPi - 1);
  EXPECT_EQ(w.out.elevation[0], 0.25);
  EXPECT_EQ(w.out.view_index[0], 0U);
  w.turn(1.5, -0.125);
  EXPECT_NEAR(w.out.heading[0], 0.5, 1e-15);
  EXPECT_EQ(w.out.elevation[0], 0.125);
  w.turn(-100, -100);
  EXPECT_NEAR(w.out.heading[0], std::fmod(0.5 - 100, 2 * kPi) + 2 * kPi, 1e-14);
  EXPECT_EQ(w.out.elevation[0], -0.5);
}

TEST(Simulator, DiscretizedViewsAre36) {
  SimulatorConfig config = SimulatorConfig::room_to_room();
  config.elevation_limits = {Radians(-0.1), Radians(0.1)};  // not looked at
  Walker w(set_of(graph::testing::square()), config);
  w.start(at(0, degrees(44.9).value, degrees(15.1).value));
  EXPECT_EQ(w.out.view_index[0], 24U + 1U);
  EXPECT_EQ(w.out.elevation[0], kPi / 6);
  w.start(at(0, degrees(345.1).value, degrees(-14.9).value));
  EXPECT_EQ(w.out.view_index[0], 12U) << "north, not a thirteenth heading";
  EXPECT_EQ(w.out.heading[0], 0);
  w.turn(-1e-9, -1e-9);  // only the sign counts
  EXPECT_EQ(w.out.view_index[0], 0U + 11U);
  w.turn(1e9, -5);
  EXPECT_EQ(w.out.view_index[0], 0U) << "down stays down";
  w.turn(0, 1);
  w.turn(0, 1);
  w.turn(0, 1);
  EXPECT_EQ(w.out.view_index[0], 24U);
}

TEST(Simulator, ExcludedViewpointsAreNotNavigable) {
  scan::Connectivity c = graph::testing::square();
  c.entries[3].included = false;
  Walker w(set_of(c), unrestricted());
  w.start(at(0));
  EXPECT_THAT(w.list(), ElementsAre(v(0), v(1)));
}

TEST(Simulator, OneAgentMayStartAgain) {
  SimulatorConfig config = unrestricted();
  config.batch_size = 3;
  Walker w(set_of(graph::testing::square()), config);
  w.simulator.new_episodes(std::vector(3, at(0)), w.out);
  w.simulator.step(std::vector<Action>(3, {1, Radians(0.5), Radians(0)}), w.out);
  w.simulator.new_episode(1, at(2, 1), w.out);
  EXPECT_THAT(w.out.viewpoint, ElementsAre(v(3), v(2), v(3)));
  EXPECT_THAT(w.out.step, ElementsAre(1U, 0U, 1U));
  EXPECT_THAT(w.out.heading, ElementsAre(0.5, 1, 0.5));
  EXPECT_THAT(w.list(1), ElementsAre(v(2), v(1), v(3)));
}

TEST(Simulator, OutputIsACopy) {
  Walker w(set_of(graph::testing::square()), unrestricted());
  w.start(at(0));
  w.out.navigable_viewpoint[1] = v(2);  // a caller's scribbling
  w.out.viewpoint[0] = v(2);
  w.out.heading[0] = 3;
  w.act({1, Radians(0), Radians(0)});
  EXPECT_EQ(w.out.viewpoint[0], v(3));
  EXPECT_EQ(w.out.heading[0], 0);
}

// What a call throws, and of which agent; "" and -1 if nothing.
struct Refusal {
  std::string text;
  int agent = -1;
};
template <class F>
Refusal refusal(const F& call) {
  try {
    call();
  } catch (const ActionError& error) {
    return {error.what(), static_cast<int>(error.agent())};
  } catch (const ArgumentError& error) {
    return {error.what(), -1};
  }
  return {};
}

TEST(SimulatorErrors, ARefusedActionLeavesTheBatchAsItWas) {
  SimulatorConfig config = unrestricted();
  config.batch_size = 3;
  Walker w(set_of(graph::testing::square()), config);
  w.simulator.new_episodes(std::vector(3, at(0)), w.out);
  const Action good{1, Radians(0.5), Radians(0.1)};
  const auto refused = [&](const Action& bad) {
    return refusal([&] { w.simulator.step(std::vector{good, bad, good}, w.out); });
  };
  const Refusal index = refused({3, Radians(0), Radians(0)});
  EXPECT_EQ(index.agent, 1);
  EXPECT_EQ(index.text,
            "agent 1: index 3 of its navigable list: 0 to 2 are allowed at viewpoint "
            "v0 of scan square");
  EXPECT_THAT(refused({0, Radians(kNaN), Radians(0)}).text, HasSubstr("heading change nan"));
  EXPECT_THAT(refused({0, Radians(0), Radians(-kInfinity)}).text,
              HasSubstr("elevation change -inf: any finite angle"));
  for (const std::uint32_t steps : {0U, 1U}) {
    EXPECT_THAT(w.out.viewpoint, ElementsAre(v(0), v(0), v(0)));
    EXPECT_THAT(w.out.step, ElementsAre(steps, steps, steps));
    EXPECT_THAT(w.out.heading, ElementsAre(0, 0, 0));
    w.simulator.step(std::vector(3, Action{0, Radians(0), Radians(0)}), w.out);
  }
}

TEST(SimulatorErrors, ARefusedStartLeavesTheBatchAsItWas) {
  scan::Connectivity c = graph::testing::square();
  c.entries[2].included = false;
  SimulatorConfig config = unrestricted();
  config.batch_size = 2;
  Walker w(set_of(c), config);
  w.simulator.new_episodes(std::vector{at(0), at(1)}, w.out);
  const auto refused = [&](const EpisodeStart& bad) {
    return refusal([&] { w.simulator.new_episodes(std::vector{at(3), bad}, w.out); });
  };
  EXPECT_EQ(refused({{ScanIndex(1), v(0)}, {}, {}}).text, "agent 1: scan 1: 0 to 0 are allowed");
  EXPECT_EQ(refused(at(4)).text, "agent 1: viewpoint 4 of scan square: 0 to 3 are allowed");
  EXPECT_EQ(refused(at(2)).text,
            "agent 1: viewpoint 2 (v2) of scan square is excluded from its graph");
  EXPECT_EQ(refused(at(1, kNaN)).text, "agent 1: heading nan: any finite angle is allowed");
  EXPECT_EQ(refused(at(1, 0, kInfinity)).text,
            "agent 1: elevation inf: any finite angle is allowed");
  EXPECT_EQ(refused(at(4)).agent, 1);
  w.simulator.step(std::vector(2, Action{0, Radians(0), Radians(0)}), w.out);
  EXPECT_THAT(w.out.viewpoint, ElementsAre(v(0), v(1)));
}

TEST(SimulatorErrors, ArgumentsOfTheWrongSizeAreNamed) {
  SimulatorConfig config;
  config.batch_size = 2;
  Walker w(set_of(graph::testing::square()), config);
  const std::vector<Action> one(1), two(2);
  const auto text = [](const auto& call) { return refusal(call).text; };
  EXPECT_EQ(text([&] { w.simulator.step(two, w.out); }), "agent 0: no episode was started");
  w.simulator.new_episode(0, at(0), w.out);
  EXPECT_EQ(text([&] { w.simulator.step(two, w.out); }), "agent 1: no episode was started");
  w.simulator.new_episode(1, at(0), w.out);
  EXPECT_EQ(text([&] { w.simulator.step(one, w.out); }), "actions: 1 elements, not 2");
  EXPECT_EQ(text([&] { w.simulator.new_episodes(std::vector{at(0)}, w.out); }),
            "starts: 1 elements, not 2");
  const ScanIndex scan(0);
  EXPECT_EQ(text([&] {
              w.simulator.new_random_episodes({&scan, 1}, w.out);
            }),
            "scans: 1 elements, not 2");
  EXPECT_EQ(text([&] { w.simulator.new_episode(2, at(0), w.out); }), "agent 2: 0 to 1 are allowed");
  StateBuffer narrow(2, 31);
  EXPECT_EQ(text([&] { w.simulator.step(two, narrow.spans()); }),
            "navigable_viewpoint: 62 elements, not 64");
  StateSpans no_heading = w.out;
  no_heading.heading = {};
  EXPECT_EQ(text([&] { w.simulator.step(two, no_heading); }), "heading: 0 elements, not 2");
}

TEST(SimulatorErrors, GraphsThatCannotBeUsedAreNamed) {
  SimulatorConfig config;
  config.max_navigable = 2;
  Walker w(set_of(graph::testing::square()), config);
  EXPECT_THAT(refusal([&] { w.start(at(0)); }).text,
              HasSubstr("scan square has a viewpoint with 2 neighbours; max_navigable 2 allows 1"));
  scan::Connectivity c = graph::testing::square();
  for (auto& entry : c.entries) entry.included = false;
  Walker empty(set_of(c), SimulatorConfig());
  const ScanIndex scan(0);
  EXPECT_THAT(refusal([&] {
                empty.simulator.new_random_episodes({&scan, 1}, empty.out);
              }).text,
              HasSubstr("no viewpoint of scan square is included"));
  EXPECT_THAT(refusal([] { Simulator(nullptr, SimulatorConfig()); }).text, HasSubstr("null"));
}

TEST(SimulatorErrors, ConfigurationsAreChecked) {
  const auto fault = [](auto&& change) {
    SimulatorConfig config;
    change(config);
    return refusal([&] { validate(config); }).text;
  };
  using C = SimulatorConfig;
  EXPECT_EQ(fault([](C&) {}), "");
  EXPECT_THAT(fault([](C& c) { c.batch_size = 0; }), HasSubstr("batch_size 0"));
  EXPECT_THAT(fault([](C& c) { c.batch_size = std::size_t{1} << 60U; }), HasSubstr("at most"));
  EXPECT_THAT(fault([](C& c) { c.max_navigable = 0; }), HasSubstr("max_navigable 0: 1 to 1024"));
  EXPECT_THAT(fault([](C& c) { c.max_navigable = 1025; }), HasSubstr("max_navigable 1025"));
  EXPECT_THAT(fault([](C& c) { c.threads = -1; }), HasSubstr("threads -1"));
  EXPECT_THAT(fault([](C& c) { c.camera.width = 0; }), HasSubstr("camera size 0 x 480"));
  EXPECT_THAT(fault([](C& c) { c.camera.vertical_field_of_view = Radians(kNaN); }),
              HasSubstr("vertical field of view nan"));
  for (const auto& [min, max] : {std::pair(-1.6, 0.5), std::pair(0.0, 0.5), std::pair(-0.5, 0.0),
                                 std::pair(-0.5, 1.6), std::pair(kNaN, 0.5)}) {
    EXPECT_THAT(fault([&](C& c) {
                  c.elevation_limits = {Radians(min), Radians(max)};
                }),
                HasSubstr("elevation_limits"))
        << min << " " << max;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::sim
