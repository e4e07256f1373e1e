#include "enfilade/continuous/habitat/greedy_follower.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/angle.h"
#include "tests/support/flat_floor.h"

namespace enfilade::continuous::habitat {
namespace EN_UNIT {

using testing::flat_floor;

constexpr FollowerSettings kSettings{.turn_degrees = 15};

// 6 x 6 m.
PathFinder square() { return flat_floor({{-3, -3, 3, 3}}); }
// The same with a wall from z = -3 to z = 1 in the middle.
PathFinder with_wall() { return flat_floor({{-3, -3, -0.2F, 1}, {0.2F, -3, 3, 1}, {-3, 1, 3, 3}}); }

Pose at(const PathFinder& floor, Vec3f position, double degrees = 0) {
  const auto half = static_cast<float>(degrees * kPi / 360);
  return {floor.snap(position), {0, std::sin(half), 0, std::cos(half)}};
}

void play(const PathFinder& floor, Moves moves, Follow action, Pose& pose) {
  const Ground ground{&floor, moves};
  if (action == Follow::kForward) act(pose, Motion::kMoveForward, kSettings.step, ground);
  if (action == Follow::kLeft) act(pose, Motion::kTurnLeft, kSettings.turn_degrees, ground);
  if (action == Follow::kRight) act(pose, Motion::kTurnRight, kSettings.turn_degrees, ground);
}

// Both ways to follow come to the goal, and stop there. Returns the plan.
std::vector<Follow> follow(const PathFinder& floor, Moves moves, const Pose& start, Vec3f goal) {
  GreedyFollower follower(floor, moves, kSettings);
  std::vector<Follow> plan = follower.path(start, goal);
  Pose pose = start;
  for (const Follow action : plan) {
    EXPECT_EQ(action == Follow::kStop, floor.path(pose.position, goal).length < 0.1875F);
    play(floor, moves, action, pose);
  }
  EXPECT_FALSE(plan.empty());
  EXPECT_EQ(std::ranges::count(plan, Follow::kStop), 1);

  pose = start;
  Follow action = Follow::kForward;
  for (std::size_t i = 0; i < 2 * plan.size() && action != Follow::kStop; ++i) {
    action = follower.next(pose, goal);
    play(floor, moves, action, pose);
  }
  EXPECT_EQ(action, Follow::kStop);
  EXPECT_LT(floor.path(pose.position, goal).length, 0.1875F);
  return plan;
}

TEST(HabitatFollower, CrossesAnEmptyRoom) {
  const PathFinder floor = square();
  const Vec3f goal = floor.snap({0, 0, -2});
  for (const Moves moves : {Moves::kSlide, Moves::kStop}) {
    // Straight ahead: 4 m less the goal radius.
    std::vector<Follow> straight(16, Follow::kForward);
    straight.back() = Follow::kStop;
    straight.insert(straight.begin(), Follow::kForward);
    std::vector<Follow> plan = follow(floor, moves, at(floor, {0, 0, 2}), goal);
    EXPECT_EQ(plan, straight);
    // It looks to the right of the goal first.
    straight.insert(straight.begin(), 6, Follow::kLeft);
    plan = follow(floor, moves, at(floor, {0, 0, 2}, -90), goal);
    EXPECT_EQ(plan, straight);
    std::ranges::replace(straight, Follow::kLeft, Follow::kRight);
    plan = follow(floor, moves, at(floor, {0, 0, 2}, 90), goal);
    EXPECT_EQ(plan, straight);
  }
}

TEST(HabitatFollower, GoesRoundAWall) {
  const PathFinder floor = with_wall();
  const Vec3f goal = floor.snap({2, 0, -2});
  for (const Moves moves : {Moves::kSlide, Moves::kStop}) {
    const auto plan = follow(floor, moves, at(floor, {-2, 0, -2}), goal);
    // 3.7 m and back, and 4 m across: more than the straight line's 16 steps.
    const auto steps = std::ranges::count(plan, Follow::kForward);
    EXPECT_GE(steps, 28);
    EXPECT_LE(steps, 36);
  }
}

TEST(HabitatFollower, StopsWithinTheGoalRadius) {
  const PathFinder floor = square();
  const Pose pose = at(floor, {1, 0, 1});
  FollowerSettings settings = kSettings;
  settings.goal_radius = 0.5F;
  GreedyFollower follower(floor, Moves::kSlide, settings);
  EXPECT_EQ(follower.path(pose, floor.snap({1.3F, 0, 1.3F})), std::vector{Follow::kStop});
  EXPECT_EQ(follower.next(pose, floor.snap({1.3F, 0, 1.3F})), Follow::kStop);
  EXPECT_GT(follower.path(pose, floor.snap({1.4F, 0, 1.4F})).size(), 1U);
}

TEST(HabitatFollower, RefusesGoalsOfAnotherIsland) {
  const PathFinder floor = flat_floor({{-3, -3, -0.5F, 3}, {0.5F, -3, 3, 3}});
  ASSERT_EQ(floor.islands(), 2U);
  GreedyFollower follower(floor, Moves::kSlide, kSettings);
  const Pose pose = at(floor, {-2, 0, 0});
  EXPECT_TRUE(follower.path(pose, floor.snap({2, 0, 0})).empty());
  EXPECT_EQ(follower.next(pose, floor.snap({2, 0, 0})), Follow::kError);
  EXPECT_EQ(follower.next(pose, {100, 0, 0}), Follow::kError);
  EXPECT_EQ(follower.next(at(floor, {100, 0, 0}), floor.snap({2, 0, 0})), Follow::kError);
  // It can go on elsewhere.
  EXPECT_EQ(follower.next(pose, floor.snap({-2, 0, -2})), Follow::kForward);
}

TEST(HabitatFollower, GivesUpWhereEachStepMeetsAWall) {
  const PathFinder floor = square();
  FollowerSettings settings = kSettings;
  settings.step = 1000;
  GreedyFollower follower(floor, Moves::kStop, settings);
  const Pose by_the_wall = at(floor, {2.8F, 0, 0});
  const Vec3f goal = floor.snap({0, 0, 0});
  ASSERT_TRUE(floor.path(by_the_wall.position, goal).found());
  EXPECT_EQ(follower.next(by_the_wall, goal), Follow::kError);
  EXPECT_TRUE(follower.path(by_the_wall, goal).empty());
}

// Asks from a body that looks to the right of the goal and to the left of it, by turns.
class Thrashing : public ::testing::Test {
 protected:
  PathFinder floor_ = square();
  Vec3f goal_ = floor_.snap({0, 0, -2});
  int asked_ = 0;

  Follow ask(GreedyFollower& follower) {
    return follower.next(at(floor_, {0, 0, 2}, asked_++ % 2 == 0 ? -90 : 90), goal_);
  }
  // Follows each view: left, right, left, ...
  void expect_to_and_fro(GreedyFollower& follower, int times) {
    for (int i = 0; i < times; ++i) {
      const Follow side = asked_ % 2 == 0 ? Follow::kLeft : Follow::kRight;
      ASSERT_EQ(ask(follower), side) << i;
    }
  }
};

TEST_F(Thrashing, EndsByGoingOnWithThePlan) {
  GreedyFollower follower(floor_, Moves::kSlide, kSettings);
  expect_to_and_fro(follower, 16);
  for (int turn = 0; turn < 6; ++turn) EXPECT_EQ(ask(follower), Follow::kLeft);
  EXPECT_EQ(ask(follower), Follow::kForward);
  expect_to_and_fro(follower, 16);
}

TEST_F(Thrashing, IsForgottenByReset) {
  GreedyFollower follower(floor_, Moves::kSlide, kSettings);
  expect_to_and_fro(follower, 16);
  follower.reset();
  expect_to_and_fro(follower, 16);
  EXPECT_EQ(ask(follower), Follow::kLeft);
  follower.reset();  // in the middle of a plan
  expect_to_and_fro(follower, 15);
}

TEST_F(Thrashing, GoesOnWithoutTheFix) {
  FollowerSettings settings = kSettings;
  settings.fix_thrashing = false;
  GreedyFollower follower(floor_, Moves::kSlide, settings);
  expect_to_and_fro(follower, 40);
}

TEST(HabitatFollower, RefusesStepsAndTurnsThatAreNotPositive) {
  const PathFinder floor = square();
  const auto make = [&](FollowerSettings settings) {
    return GreedyFollower(floor, Moves::kSlide, settings);
  };
  for (const float value : {0.0F, -1.0F, std::nanf("")}) {
    EXPECT_THROW(make({.step = value}), ArgumentError);
    EXPECT_THROW(make({.turn_degrees = value}), ArgumentError);
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::continuous::habitat
