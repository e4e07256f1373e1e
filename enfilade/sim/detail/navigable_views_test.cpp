#include "enfilade/sim/detail/navigable_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "enfilade/sim/detail/atan2f.h"

namespace enfilade::sim::detail {
namespace EN_UNIT {

using ::testing::ElementsAre;

graph::Edge edge_to(std::size_t target, float dx, float dy, double elevation) {
  graph::Edge edge;
  edge.target = ViewpointIndex(target);
  edge.dx = dx;
  edge.dy = dy;
  edge.unit_x = dx / std::hypot(dx, dy);
  edge.unit_y = dy / std::hypot(dx, dy);
  edge.elevation = Radians(elevation);
  return edge;
}

// The list of one agent that looks north and level from viewpoint 9.
std::vector<std::uint32_t> list(const std::vector<graph::Edge>& edges, const ViewLimit& limit) {
  NavigableViews views(1, 8);
  views.clear();
  views.add(edges, FloorDirection{0, 1}, 0, limit);
  views.compute();
  std::array<std::uint32_t, 8> target{};
  std::array<ViewpointIndex, 8> viewpoint{};
  std::array<double, 8> right{}, up{}, distance{};
  const std::uint32_t count =
      views.write(ViewpointIndex(9),
                  {target.data(), viewpoint.data(), right.data(), up.data(), distance.data()});
  return {target.begin(), target.begin() + count};
}

TEST(NavigableViews, TheBoundItselfIsInView) {
  const std::vector<graph::Edge> edges{edge_to(1, 0, 2, 0), edge_to(2, 1, 2, 0)};
  EXPECT_THAT(list(edges, {false, 1}), ElementsAre(9U, 1U));
  EXPECT_THAT(list(edges, {false, 1.0000000001}), ElementsAre(9U));
  EXPECT_THAT(list(edges, {true, 2}), ElementsAre(9U, 1U, 2U));
}

// Angles that differ by less than their square root can show are a tie, as they were in MatterSim:
// sorting by the squares would put the later viewpoint first.
TEST(NavigableViews, OrderIsByTheRoundedRoot) {
  const auto h = static_cast<double>(atan2f_fdlibm(2, 1));
  const auto square = [h](double elevation) { return h * h + elevation * elevation; };
  int ties = 0;
  for (double low = 0.3; low < 0.4; low += 0.001) {
    double high = low;
    while (square(high) == square(low)) high = std::nextafter(high, 1.0);
    const bool tie = std::sqrt(square(high)) == std::sqrt(square(low));
    ties += tie ? 1 : 0;
    const std::vector<graph::Edge> edges{edge_to(1, 2, 1, high), edge_to(2, 2, 1, low)};
    if (tie) {
      ASSERT_THAT(list(edges, {true, 0}), ElementsAre(9U, 1U, 2U)) << low;
    } else {
      ASSERT_THAT(list(edges, {true, 0}), ElementsAre(9U, 2U, 1U)) << low;
    }
  }
  EXPECT_GT(ties, 20) << "about half of all pairs are";
  EXPECT_LT(ties, 80);
}

TEST(NavigableViews, AgentsDoNotMix) {
  NavigableViews views(3, 4);
  const std::vector<graph::Edge> two{edge_to(1, 1, 1, 0), edge_to(2, 0, 1, 0)};
  const std::vector<graph::Edge> none;
  std::array<std::uint32_t, 4> target{};
  std::array<ViewpointIndex, 4> viewpoint{};
  std::array<double, 4> right{}, up{}, distance{};
  const NavigableRow row{target.data(), viewpoint.data(), right.data(), up.data(), distance.data()};
  for (int round = 0; round < 2; ++round) {
    views.clear();
    views.add(two, FloorDirection{0, 1}, 0, {true, 0});
    views.add(none, FloorDirection{0, 1}, 0, {true, 0});
    views.add(two, FloorDirection{1, 0}, 0, {false, 0.5});
    views.compute();
    EXPECT_EQ(views.write(ViewpointIndex(0), row), 3U);
    EXPECT_THAT(target, ElementsAre(0U, 2U, 1U, ::testing::_));
    EXPECT_EQ(views.write(ViewpointIndex(5), row), 1U);
    EXPECT_EQ(target[0], 5U);
    EXPECT_EQ(views.write(ViewpointIndex(7), row), 2U);
    EXPECT_EQ(viewpoint[1], ViewpointIndex(1));
    EXPECT_EQ(right[1], -static_cast<double>(atan2f_fdlibm(1, 1)));
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::sim::detail
