#include "enfilade/graph/compare.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"
#include "tests/support/graphs.h"

namespace enfilade::graph {
namespace EN_UNIT {

using testing::connectivity;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

const std::vector<Vec3d> kCorners{{0, 0, 1.5}, {2, 0, 1.5}, {2, 2, 1.5}, {0, 2, 1.5}};

MATCHER_P2(IsEdge, a, b, "") {
  return arg.a == ViewpointIndex(std::size_t{a}) && arg.b == ViewpointIndex(std::size_t{b});
}

TEST(Compare, EqualGraphsAgree) {
  const NavGraph square(testing::square());
  const GraphComparison c = compare(square, square);
  EXPECT_EQ(c.matched, 4U);
  EXPECT_EQ(c.common, 4U);
  EXPECT_THAT(c.extra, IsEmpty());
  EXPECT_THAT(c.missing, IsEmpty());
  EXPECT_DOUBLE_EQ(c.f1(), 1);
}

TEST(Compare, CountsByHand) {
  const NavGraph found(connectivity("x", kCorners, {{0, 1}, {1, 2}, {0, 2}, {1, 3}}));
  const NavGraph truth(connectivity("x", kCorners, {{0, 1}, {1, 2}, {2, 3}}));
  const GraphComparison c = compare(found, truth);
  EXPECT_EQ(c.common, 2U);
  EXPECT_THAT(c.extra, ElementsAre(IsEdge(0U, 2U), IsEdge(1U, 3U)));
  EXPECT_THAT(c.missing, ElementsAre(IsEdge(2U, 3U)));
  EXPECT_DOUBLE_EQ(c.extra[0].length, std::sqrt(8.0));
  EXPECT_DOUBLE_EQ(c.precision(), 2.0 / 4);
  EXPECT_DOUBLE_EQ(c.recall(), 2.0 / 3);
  EXPECT_DOUBLE_EQ(c.f1(), 4.0 / 7);  // 2 * 2 / (2 * 2 + 2 + 1)
}

TEST(Compare, NoEdgesAreNoFault) {
  const NavGraph none(connectivity("x", kCorners, {}));
  const NavGraph square(testing::square("x"));
  EXPECT_DOUBLE_EQ(compare(none, none).f1(), 1);
  EXPECT_DOUBLE_EQ(compare(none, square).precision(), 1);
  EXPECT_DOUBLE_EQ(compare(none, square).recall(), 0);
  EXPECT_DOUBLE_EQ(compare(square, none).precision(), 0);
}

TEST(Compare, OneWayEdgesCountOnce) {
  scan::Connectivity one_way = connectivity("x", kCorners, {{0, 1}});
  one_way.entries[0].unobstructed.clear();  // 1 to 0 is left
  const NavGraph found(one_way), truth(connectivity("x", kCorners, {{0, 1}}));
  EXPECT_EQ(compare(found, truth).common, 1U);
  EXPECT_THAT(compare(truth, found).extra, IsEmpty());
}

TEST(Compare, MatchesByIdInAnyOrder) {
  scan::Connectivity turned = connectivity("x", {kCorners[1], kCorners[0], {50, 0, 1.5}}, {{0, 1}});
  turned.entries[0].id = "v1";
  turned.entries[1].id = "v0";
  turned.entries[2].id = "far";
  const NavGraph found(connectivity("x", kCorners, {{0, 1}, {1, 2}})), truth(turned);
  const GraphComparison c = compare(found, truth);
  EXPECT_EQ(c.matched, 2U);
  EXPECT_EQ(c.common, 1U);
  EXPECT_THAT(c.extra, IsEmpty());  // 1 - 2 leads to one without a partner
  EXPECT_THAT(c.only_found, ElementsAre("v2", "v3"));
  EXPECT_THAT(c.only_truth, ElementsAre("far"));
}

TEST(Compare, MatchesByPlaceIfNoIdIsShared) {
  std::vector<Vec3d> moved = kCorners;
  for (Vec3d& p : moved) p.x += 0.3;
  moved.push_back({0.1, 0, 1.5});  // nearer to the first corner than the one moved from there
  scan::Connectivity other = connectivity("x", moved, {{0, 1}, {1, 4}});
  for (auto& entry : other.entries) entry.id += "'";
  const NavGraph found(connectivity("x", kCorners, {{0, 1}})), truth(other);
  const GraphComparison c = compare(found, truth);
  EXPECT_EQ(c.matched, 4U);
  EXPECT_EQ(c.common, 1U);  // 1 - 4
  EXPECT_THAT(c.only_truth, ElementsAre("v0'"));
}

TEST(Compare, ExcludedViewpointsHaveNoPart) {
  scan::Connectivity left_out = testing::square("x");
  left_out.entries[0].included = false;
  const NavGraph found(testing::square("x")), truth(left_out);
  const GraphComparison c = compare(found, truth);
  EXPECT_EQ(c.matched, 3U);
  EXPECT_EQ(c.common, 2U);
  EXPECT_THAT(c.extra, IsEmpty());
  EXPECT_THAT(c.only_found, ElementsAre("v0"));
}

TEST(Compare, RefusesGraphsThatShareNothing) {
  scan::Connectivity far = connectivity("y", {{90, 0, 0}}, {});
  far.entries[0].id = "other";
  const NavGraph found(testing::square("x")), truth(far);
  EXPECT_THROW(compare(found, truth), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::graph
