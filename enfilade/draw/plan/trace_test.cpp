#include "enfilade/draw/plan/trace.h"

#include <gtest/gtest.h>

namespace enfilade::draw::plan {
namespace EN_UNIT {

std::vector<ViewpointIndex> route(std::initializer_list<std::size_t> places) {
  std::vector<ViewpointIndex> path;
  for (const std::size_t place : places) path.emplace_back(place);
  return path;
}

TEST(Lanes, KeepToTheMiddleOfAnEdgeThatIsUsedOnce) {
  const auto steps = lanes({route({0, 1, 1, 2})}, 6);
  ASSERT_EQ(steps.at(0).size(), 2U) << "turning on the spot is no step";
  for (const Step& step : steps[0]) EXPECT_EQ(step.side, 0);
}

TEST(Lanes, GoAndReturnOnEachOnesRight) {
  const auto steps = lanes({route({0, 1, 0})}, 6).at(0);
  EXPECT_EQ(steps.at(0).side, 3);
  EXPECT_EQ(steps.at(1).side, 3) << "to the right of the opposite direction: the other side";
}

TEST(Lanes, PutASecondUseFurtherOut) {
  const auto steps = lanes({route({0, 1}), route({0, 1})}, 6);
  EXPECT_EQ(steps[0][0].side, 3);
  EXPECT_EQ(steps[1][0].side, 9) << "another path over the edge";
}

TEST(Lanes, StayCloseHoweverOftenAnEdgeIsUsed) {
  std::vector<ViewpointIndex> path;
  for (std::size_t i = 0; i < 100; ++i) path.emplace_back(i % 2);
  const auto steps = lanes({path}, 6);
  for (const Step& step : steps.at(0)) EXPECT_LT(step.side, 22);
}

TEST(Mix, GoesFromOneColourToTheOther) {
  EXPECT_EQ(hex(mix({0, 0, 0}, {255, 100, 0}, 0)), "#000000");
  EXPECT_EQ(hex(mix({0, 0, 0}, {255, 100, 0}, 1)), "#ff6400");
  EXPECT_EQ(hex(mix({0, 0, 0}, {200, 100, 0}, 0.5)), "#643200");
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw::plan
