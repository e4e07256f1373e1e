#include "enfilade/homes/speaking/instructions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/graphs.h"

namespace enfilade::homes::speaking {
namespace {

using ::testing::ElementsAre;

// From a kitchen north into a hallway, there to the east, and south into a bath.
TEST(DescribePath, SaysTurnsAndRooms) {
  const graph::NavGraph graph(graph::testing::connectivity(
      "s", {{0, 0, 1.5}, {0, 2, 1.5}, {3, 2, 1.5}, {3, 0, 1.5}}, {{0, 1}, {1, 2}, {2, 3}}));
  const std::vector<std::string> rooms{"kitchen", "hallway", "hallway", "bath"};
  const std::vector<ViewpointIndex> path{ViewpointIndex(0), ViewpointIndex(1), ViewpointIndex(2),
                                         ViewpointIndex(3)};
  const RoomOf room_of = [&](ViewpointIndex v) -> const std::string& { return rooms[v.at()]; };
  EXPECT_THAT(
      describe_path(graph, path, degrees(180), room_of),
      ElementsAre("Leave the kitchen, turn right into the hallway, turn right and stop in "
                  "the bath.",
                  "Turn around and walk out of the kitchen. Turn right and walk through the "
                  "hallway. Turn right. Enter the bath and wait there.",
                  "From the kitchen find the bath. Go through the hallway. Stop after about "
                  "7 metres, in the bath."));
  EXPECT_THAT(describe_path(graph, path, degrees(0), room_of)[1],
              ::testing::StartsWith("Walk out of the kitchen. Turn right"));
}

TEST(DescribePath, GoesUpAndDownStairs) {
  const graph::NavGraph graph(
      graph::testing::connectivity("s", {{0, 0, 1.5}, {0, 2, 3}, {0, 4, 4.5}}, {{0, 1}, {1, 2}}));
  const std::vector<std::string> rooms{"hallway", "stairs", "landing"};
  const RoomOf room_of = [&](ViewpointIndex v) -> const std::string& { return rooms[v.at()]; };
  const ViewpointIndex below(0), middle(1), above(2);
  EXPECT_EQ(describe_path(graph, {below, middle, above}, {}, room_of)[0],
            "Leave the hallway, go up the stairs and stop in the landing.");
  EXPECT_EQ(describe_path(graph, {above, middle, below}, {}, room_of)[0],
            "Leave the landing, go down the stairs and stop in the hallway.");
  EXPECT_EQ(describe_path(graph, {below, middle}, {}, room_of)[2],
            "From the hallway find the stairs. It is the next room. Stop after about 2 metres, on "
            "the stairs.");
}

}  // namespace
}  // namespace enfilade::homes::speaking
