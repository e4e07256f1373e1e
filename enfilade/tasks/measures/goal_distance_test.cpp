#include "enfilade/tasks/goal_distance.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/graphs.h"

namespace enfilade::tasks {
namespace EN_UNIT {

constexpr double kRadius = 3;

constexpr ViewpointIndex v(std::size_t i) { return ViewpointIndex(i); }

// v0 -4 m- v1 -4 m- v2 -4 m- v3 in a row, and v4 out of reach.
const graph::NavGraph& row() {
  static const graph::NavGraph kGraph(graph::testing::connectivity(
      "row", {{0, 0, 0}, {4, 0, 0}, {8, 0, 0}, {12, 0, 0}, {99, 0, 0}}, {{0, 1}, {1, 2}, {2, 3}}));
  return kGraph;
}

// From v0 to v2.
ReferencePath path_with(Goal goal) {
  return {1, ScanIndex(0), Radians(0), {v(0), v(1), v(2)}, std::move(goal)};
}

Box box_at(std::size_t viewpoint) { return {v(viewpoint), {}, {}}; }

TEST(GoalDistance, OfAPathIsToItsEnd) {
  const ReferencePath path = path_with(NearEnd{});
  EXPECT_DOUBLE_EQ(distance_to_goal(row(), path, v(0)), 8);
  EXPECT_DOUBLE_EQ(distance_to_goal(row(), path, v(0), Leg::kBack), 8);
  EXPECT_EQ(nearest_goal(row(), path, v(0)), v(2));
  EXPECT_TRUE(goal_reached(row(), path, v(2), Leg::kOut, kRadius));
  EXPECT_TRUE(goal_reached(row(), path, v(1), Leg::kOut, 4.5));
  EXPECT_FALSE(goal_reached(row(), path, v(1), Leg::kOut, 4)) << "strictly nearer";
  EXPECT_DOUBLE_EQ(shortest_to_goal(row(), path, v(0)), 8);
}

TEST(GoalDistance, OfAHiddenGoalIsNotANumber) {
  ReferencePath path = path_with(HiddenGoal{});
  for (int i = 0; i < 2; ++i) {
    EXPECT_TRUE(std::isnan(distance_to_goal(row(), path, v(0))));
    EXPECT_TRUE(std::isnan(shortest_to_goal(row(), path, v(0))));
    EXPECT_EQ(nearest_goal(row(), path, v(0)), std::nullopt);
    EXPECT_FALSE(goal_reached(row(), path, v(0), Leg::kOut, kRadius));
    path = {1, ScanIndex(0), Radians(0), {v(0)}, NearEnd{}};  // as R2R's test has it
  }
}

TEST(GoalDistance, OfATurningPointLeadsThereFirst) {
  const ReferencePath path{1, ScanIndex(0), Radians(0), {v(0), v(3), v(1)}, TurningPoint{v(3)}};
  EXPECT_DOUBLE_EQ(distance_to_goal(row(), path, v(0)), 12 + 8);
  EXPECT_DOUBLE_EQ(distance_to_goal(row(), path, v(2), Leg::kBack), 4);
  EXPECT_EQ(nearest_goal(row(), path, v(0)), v(3));
  EXPECT_EQ(nearest_goal(row(), path, v(3), Leg::kBack), v(1));
  EXPECT_EQ(leg_after(row(), path, v(2), Leg::kOut, kRadius), Leg::kOut);
  EXPECT_EQ(leg_after(row(), path, v(2), Leg::kOut, 4), Leg::kBack) << "at most that far";
  EXPECT_EQ(leg_after(row(), path, v(0), Leg::kBack, kRadius), Leg::kBack);
  EXPECT_FALSE(goal_reached(row(), path, v(1), Leg::kOut, kRadius)) << "it has not been there";
  EXPECT_TRUE(goal_reached(row(), path, v(1), Leg::kBack, kRadius));
  EXPECT_TRUE(goal_reached(row(), path, v(2), Leg::kBack, 4)) << "at most that far";
  EXPECT_DOUBLE_EQ(shortest_to_goal(row(), path, v(0)), 20);
}

TEST(GoalDistance, OfAnObjectIsToWhereItIsSeen) {
  const ReferencePath path = path_with(SeenObject{66, {v(1), v(3)}});
  EXPECT_DOUBLE_EQ(distance_to_goal(row(), path, v(0)), 4);
  EXPECT_EQ(nearest_goal(row(), path, v(2)), v(1)) << "of equally near ones the first";
  EXPECT_TRUE(goal_reached(row(), path, v(3), Leg::kOut, kRadius));
  EXPECT_FALSE(goal_reached(row(), path, v(2), Leg::kOut, 99)) << "near is not enough";
  EXPECT_DOUBLE_EQ(shortest_to_goal(row(), path, v(1)), 8) << "of the path, as REVERIE's scorer";
  const ReferencePath unseen = path_with(SeenObject{66, {}});
  EXPECT_TRUE(std::isinf(distance_to_goal(row(), unseen, v(0))));
  EXPECT_EQ(nearest_goal(row(), unseen, v(0)), std::nullopt);
}

TEST(GoalDistance, OfARegionIsToItsNearestViewpoint) {
  const ReferencePath path = path_with(Region{{v(3), v(2)}, {}, {}});
  EXPECT_DOUBLE_EQ(distance_to_goal(row(), path, v(0)), 8);
  EXPECT_EQ(nearest_goal(row(), path, v(0)), v(2));
  EXPECT_TRUE(goal_reached(row(), path, v(3), Leg::kOut, kRadius));
  EXPECT_FALSE(goal_reached(row(), path, v(1), Leg::kOut, 99));
  EXPECT_DOUBLE_EQ(shortest_to_goal(row(), path, v(3)), 8);
  EXPECT_TRUE(std::isinf(distance_to_goal(row(), path, v(4))));
}

TEST(GoalDistance, OfBoxesIsToTheNearestViewpointThatHasOne) {
  const ReferencePath path = path_with(Boxes{{box_at(1), box_at(2)}, {}});
  EXPECT_DOUBLE_EQ(distance_to_goal(row(), path, v(0)), 4);
  EXPECT_EQ(nearest_goal(row(), path, v(0)), v(1));
  EXPECT_TRUE(goal_reached(row(), path, v(1), Leg::kOut, kRadius));
  EXPECT_FALSE(goal_reached(row(), path, v(3), Leg::kOut, kRadius));
  EXPECT_TRUE(goal_reached(row(), path, v(3), Leg::kOut, 5)) << "near the path's end";
  EXPECT_DOUBLE_EQ(shortest_to_goal(row(), path, v(1)), 4) << "the goal moves with the agent";
  EXPECT_DOUBLE_EQ(shortest_to_goal(row(), path, v(3)), 8);
  EXPECT_EQ(nearest_goal(row(), path_with(Boxes{}), v(0)), v(2)) << "without boxes the end";
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
