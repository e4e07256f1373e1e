#include "enfilade/continuous/simulator.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>

#include "tests/support/made_meshes.h"

namespace enfilade::continuous {
namespace EN_UNIT {

using mesh::testing::Maker;

std::shared_ptr<const Buildings> buildings_of(mesh::Mesh made) {
  const mesh::RayTracer tracer(std::make_shared<const mesh::Mesh>(std::move(made)));
  return std::make_shared<const Buildings>(std::vector<Building>{
      {"room", std::make_shared<const NavigationMesh>(make_floor_polygons(tracer))}});
}

// 5 x 4 m, with a pillar of 1 x 1 m in the middle.
std::shared_ptr<const Buildings> pillar_room() {
  return buildings_of(Maker().room(0, 0, 5, 4).box({2, 1.5F, 0}, {3, 2.5F, 2.6F}).mesh);
}

EpisodeStart start_at(float x, float y, double heading_degrees) {
  return {.building = 0, .pose = {{x, y, 0}, degrees(heading_degrees), {}}};
}

Simulator one(const SimulatorConfig& config = SimulatorConfig::room_to_room()) {
  return {pillar_room(), config};
}

void step(Simulator& simulator, Action action) { simulator.step(std::span(&action, 1)); }

// Nothing on the way: VLN-CE's convention, as its experts' walks show it.
TEST(ContinuousSimulator, MovesByDeadReckoning) {
  Simulator s = one();
  s.new_episode(0, start_at(1, 1, 0));
  step(s, Action::kForward);
  EXPECT_NEAR(s.state().position[0].y, 1.25, 1e-6);
  for (int k = 0; k < 6; ++k) step(s, Action::kRight);
  EXPECT_DOUBLE_EQ(s.state().heading[0], kPi / 2);
  step(s, Action::kForward);
  EXPECT_NEAR(s.state().position[0].x, 1.25, 1e-6);
  EXPECT_NEAR(s.state().position[0].y, 1.25, 1e-6);
  for (int k = 0; k < 8; ++k) step(s, Action::kLeft);
  EXPECT_NEAR(s.state().heading[0], 2 * kPi - degrees(30).value, 1e-12);
  EXPECT_EQ(s.state().steps[0], 16U);
  EXPECT_EQ(s.state().collisions[0], 0U);
}

TEST(ContinuousSimulator, FullTurnsAreNone) {
  Simulator s = one();
  s.new_episode(0, start_at(1, 1, 17));
  const double before = s.state().heading[0];
  for (int k = 0; k < 240; ++k) step(s, Action::kLeft);
  EXPECT_NEAR(s.state().heading[0], before, 1e-12);
}

TEST(ContinuousSimulator, SlidesAlongWallsAndCountsCollisions) {
  Simulator s = one();
  s.new_episode(0, start_at(1, 0.2F, 135));  // towards the wall y = 0 at 45 degrees
  step(s, Action::kForward);
  const Vec3f slid = s.state().position[0];
  EXPECT_NEAR(slid.x, 1 + 0.25 * std::sqrt(0.5), 1e-4);
  EXPECT_NEAR(slid.y, 0.1, 0.025);
  EXPECT_EQ(s.state().collided[0], 1);
  EXPECT_EQ(s.state().collisions[0], 1U);
  step(s, Action::kLeft);
  EXPECT_EQ(s.state().collided[0], 0);
  EXPECT_EQ(s.state().collisions[0], 1U);
}

TEST(ContinuousSimulator, StopsAtWallsWhereSlidingIsOff) {
  Simulator s = one(SimulatorConfig::room_across_room());
  s.new_episode(0, start_at(1, 0.2F, 135));
  for (int k = 0; k < 5; ++k) step(s, Action::kForward);
  const Vec3f at = s.state().position[0];
  EXPECT_NEAR(at.x - 1, 0.2 - at.y, 2e-4);  // never left the line
  EXPECT_NEAR(at.y, 0.1, 0.025);
  EXPECT_GE(s.state().collisions[0], 4U);
}

TEST(ContinuousSimulator, LooksUpAndDownWithinLimits) {
  Simulator s = one(SimulatorConfig::room_across_room());
  s.new_episode(0, start_at(1, 1, 0));
  for (int k = 0; k < 3; ++k) step(s, Action::kLookUp);
  EXPECT_DOUBLE_EQ(s.state().elevation[0], degrees(60).value);
  for (int k = 0; k < 9; ++k) step(s, Action::kLookDown);
  EXPECT_DOUBLE_EQ(s.state().elevation[0], -degrees(60).value);
}

TEST(ContinuousSimulator, EndsByStopOrAfterItsLastStep) {
  SimulatorConfig config;
  config.most_steps = 3;
  Simulator s = one(config);
  s.new_episode(0, start_at(1, 1, 0));
  step(s, Action::kStop);
  EXPECT_EQ(s.state().episode[0], EpisodeState::kStopped);
  step(s, Action::kForward);  // is not heard any more
  EXPECT_EQ(s.state().steps[0], 1U);
  EXPECT_FLOAT_EQ(s.state().position[0].y, 1);
  s.new_episode(0, start_at(1, 1, 0));
  EXPECT_EQ(s.state().episode[0], EpisodeState::kWalking);
  for (int k = 0; k < 5; ++k) step(s, Action::kLeft);
  EXPECT_EQ(s.state().episode[0], EpisodeState::kCutShort);
  EXPECT_EQ(s.state().steps[0], 3U);
}

TEST(ContinuousSimulator, StartsExactlyWhereItIsTold) {
  Simulator s = one();
  const EpisodeStart start{.building = 0, .pose = {{0.05F, 1, 0.1F}, Radians(-1), Radians(0.2)}};
  s.new_episode(0, start);
  EXPECT_EQ(s.state().position[0], start.pose.position);
  EXPECT_NEAR(s.state().heading[0], 2 * kPi - 1, 1e-12);
  EXPECT_NEAR(s.state().off_floor[0], std::hypot(0.05, 0.1), 0.02);
  step(s, Action::kForward);
  EXPECT_NEAR(s.state().position[0].z, 0, 1e-5);
}

TEST(ContinuousSimulator, SaysWhatIsWrongWithAStart) {
  Simulator s = one();
  s.new_episode(0, start_at(1, 1, 0));
  const auto message = [&](const EpisodeStart& start) -> std::string {
    try {
      s.new_episode(0, start);
    } catch (const ActionError& e) {
      EXPECT_EQ(e.agent(), 0U);
      return e.what();
    }
    return "";
  };
  EXPECT_THAT(message({.building = 1, .pose = {}}),
              ::testing::HasSubstr("building 1, there are 1"));
  EXPECT_THAT(message(start_at(std::numeric_limits<float>::quiet_NaN(), 1, 0)),
              ::testing::HasSubstr("not finite"));
  EXPECT_THAT(message({.building = 0, .pose = {{1, 1, 1.2F}, {}, {}}}),
              ::testing::AllOf(::testing::HasSubstr("no floor of room within 0.5 m"),
                               ::testing::HasSubstr("1.20 m below")));
  EXPECT_THAT(message(start_at(100, 1, 0)), ::testing::HasSubstr("none within 20 m"));
  EXPECT_FLOAT_EQ(s.state().position[0].x, 1);  // nothing has happened
  EXPECT_THROW(s.new_episode(1, start_at(1, 1, 0)), ArgumentError);
}

TEST(ContinuousSimulator, RefusesWhatIsNoAction) {
  Simulator s = one();
  EXPECT_THROW(step(s, Action::kForward), ArgumentError);  // no episode yet
  s.new_episode(0, start_at(1, 1, 0));
  EXPECT_THROW(step(s, static_cast<Action>(6)), ActionError);
  EXPECT_THROW(s.step(std::vector<Action>(2)), ArgumentError);
  EXPECT_EQ(s.state().steps[0], 0U);
}

TEST(ContinuousSimulator, ConfigsOutOfRangeAreNamed) {
  const auto message = [](auto&& change) -> std::string {
    SimulatorConfig config;
    change(config);
    try {
      validate(config);
    } catch (const ArgumentError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_THAT(message([](auto& c) { c.batch_size = 0; }), ::testing::StartsWith("batch_size"));
  EXPECT_THAT(message([](auto& c) { c.forward = 0; }), ::testing::StartsWith("forward"));
  EXPECT_THAT(message([](auto& c) { c.turn = Radians(4); }), ::testing::StartsWith("turn"));
  EXPECT_THAT(message([](auto& c) { c.most_steps = 0; }), ::testing::StartsWith("most_steps"));
  EXPECT_THROW(Simulator(nullptr, {}), ArgumentError);
}

Action random_action(Rng& rng) { return static_cast<Action>(1 + rng.below(3)); }

// A million random steps: nobody is in a wall, in the pillar, or off the floor.
TEST(ContinuousSimulator, NobodyEndsInAWall) {
  SimulatorConfig config;
  config.batch_size = 100;
  config.most_steps = 20'000;
  Simulator s(pillar_room(), config);
  Rng rng(5);
  std::vector<EpisodeStart> starts;
  for (std::size_t a = 0; a < 100; ++a) starts.push_back(start_at(1, 1, static_cast<double>(a)));
  s.new_episodes(starts);
  std::vector<Action> actions(100);
  // A cell, in which each rim is, and what its line may deviate.
  constexpr double kRadius = 0.1 - 0.0125 - 0.01;
  for (int step = 0; step < 10'000; ++step) {
    for (Action& action : actions) action = random_action(rng);
    s.step(actions);
    for (const Vec3f p : s.state().position) {
      const double wall = std::min(std::min(p.x, 5 - p.x), std::min(p.y, 4 - p.y));
      const double pillar = std::max(std::abs(p.x - 2.5F), std::abs(p.y - 2)) - 0.5;
      ASSERT_GE(wall, kRadius);
      ASSERT_GE(pillar, kRadius - 0.03);  // an arc of 0.1 m, cut by lines, beside a corner
      ASSERT_NEAR(p.z, 0, 1e-5);
    }
  }
}

TEST(ContinuousSimulator, IsTheSameInAnyBatchWithAnyThreads) {
  const auto buildings = buildings_of(mesh::testing::two_storeys().mesh);
  constexpr std::size_t kAgents = 200;
  Rng rng(9);
  std::vector<EpisodeStart> starts;
  for (std::size_t a = 0; a < kAgents; ++a) {
    starts.push_back({.building = 0,
                      .pose = {buildings->floor(0).random_point(rng, std::nullopt).point,
                               Radians(rng.uniform() * 2 * kPi),
                               {}}});
  }
  std::vector<std::vector<Action>> actions(100, std::vector<Action>(kAgents));
  for (auto& list : actions) {
    for (Action& action : list) action = random_action(rng);
  }
  const auto walk = [&](std::size_t first, std::size_t count, int threads) {
    SimulatorConfig config;
    config.batch_size = count;
    config.threads = threads;
    Simulator s(buildings, config);
    s.new_episodes(std::span(starts).subspan(first, count));
    std::vector<Vec3f> places;
    for (const auto& list : actions) {
      s.step(std::span(list).subspan(first, count));
      places.insert(places.end(), s.state().position.begin(), s.state().position.end());
    }
    return places;
  };
  const std::vector<Vec3f> all = walk(0, kAgents, 1);
  EXPECT_EQ(walk(0, kAgents, 3), all);
  for (const std::size_t agent : {0U, 57U, 199U}) {
    const std::vector<Vec3f> alone = walk(agent, 1, 1);
    for (std::size_t t = 0; t < alone.size(); ++t) {
      ASSERT_EQ(alone[t], all[t * kAgents + agent]);
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::continuous
