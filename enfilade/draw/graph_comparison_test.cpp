#include "enfilade/draw/floor_plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"
#include "tests/support/graphs.h"

namespace enfilade::draw {
namespace EN_UNIT {

using graph::NavGraph;
using graph::testing::connectivity;
using ::testing::HasSubstr;
using ::testing::Not;

const std::vector<Vec3d> kCorners{{0, 0, 1.5}, {2, 0, 1.5}, {2, 2, 1.5}, {0, 2, 1.5}};
constexpr const char* kRed = "#d62728";

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (auto at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

TEST(GraphComparisonSvg, DrawsExtraRedAndMissingDashed) {
  const NavGraph found(connectivity("made", kCorners, {{0, 1}, {1, 2}, {0, 2}}));
  const NavGraph truth(connectivity("made", kCorners, {{0, 1}, {1, 2}, {2, 3}}));
  const std::string svg = graph_comparison_svg(found, graph::compare(found, truth));
  EXPECT_THAT(svg, HasSubstr("precision 0.667, recall 0.667, F1 0.667: 2 edges in both, 1 extra, "
                             "1 missing"));
  EXPECT_EQ(count(svg, kRed), 2U);  // one path on the plan, and the legend's
  EXPECT_EQ(count(svg, "stroke-dasharray=\"6 4\""), 2U);
  EXPECT_TRUE(svg.starts_with("<svg"));
  EXPECT_TRUE(svg.ends_with("</svg>\n"));
}

TEST(GraphComparisonSvg, EqualGraphsHaveNoColours) {
  const NavGraph found(graph::testing::square());
  const std::string svg = graph_comparison_svg(found, graph::compare(found, found));
  EXPECT_THAT(svg, HasSubstr("F1 1.000: 4 edges in both, 0 extra, 0 missing"));
  EXPECT_EQ(count(svg, kRed), 1U);  // the legend's
}

TEST(GraphComparisonSvg, EscapesTextsAndLabelsViewpoints) {
  const NavGraph found(graph::testing::square());
  ComparisonPlanOptions options;
  options.title = "a < b";
  options.note = "x & y";
  options.label_viewpoints = true;
  const std::string svg = graph_comparison_svg(found, graph::compare(found, found), options);
  EXPECT_THAT(svg, HasSubstr("a &lt; b"));
  EXPECT_THAT(svg, HasSubstr("x &amp; y"));
  EXPECT_THAT(svg, HasSubstr(">3</text>"));
  EXPECT_THAT(svg, Not(HasSubstr("a < b")));
}

TEST(GraphComparisonSvg, RefusesEdgesOfAnotherGraph) {
  const NavGraph found(graph::testing::square());
  graph::GraphComparison wrong;
  wrong.missing.push_back({ViewpointIndex(std::size_t{0}), ViewpointIndex(std::size_t{4}), 1.0});
  EXPECT_THROW(graph_comparison_svg(found, wrong), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw
