#include "enfilade/report/scaling_curve.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"

namespace enfilade::report {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;

ScalingCurve curve() {
  return {"Success & homes",
          true,
          {{100, 1, {0.3, 0.25, 0.35}, {0.28, 0.2, 0.3}}, {10, 1, {0.1, 0.05, 0.15}, {}}},
          tasks::MeanInterval{0.05, 0.02, 0.08},
          {{"iterations", "20 < 30"}}};
}

// The sheet is 720 x 400: the axis begins at x 80, ends at 672, and y 0 % is 348, 30 % (the top
// here, in steps of 10: 40 %) at 44 + 304 / 4.
TEST(ScalingCurve, PointsLieWhereTheirNumbersAre) {
  const std::string svg = scaling_curve_svg(curve());
  EXPECT_THAT(svg, HasSubstr("cx=\"80.0\" cy=\"272.0\""));   // 10 buildings, 10 %
  EXPECT_THAT(svg, HasSubstr("cx=\"672.0\" cy=\"120.0\""));  // 100 buildings, 30 %
  EXPECT_THAT(svg, HasSubstr("d=\"M80.0 272.0L672.0 120.0\""));
  EXPECT_THAT(svg, HasSubstr("random"));
  EXPECT_THAT(svg, HasSubstr("Success &amp; homes (SYNTHETIC)"));
}

TEST(ScalingCurve, TheAxisIsLogarithmicAndSeedsLieSideBySide) {
  ScalingCurve three = curve();
  three.points.push_back({32, 1, {0.2, 0.2, 0.2}, {}});
  three.points.push_back({32, 2, {0.2, 0.2, 0.2}, {}});
  // ln(3.2) / ln(10) of 592 pixels is 299.0; 3.5 to both sides.
  const std::string svg = scaling_curve_svg(three);
  EXPECT_THAT(svg, HasSubstr("cx=\"375.5\""));
  EXPECT_THAT(svg, HasSubstr("cx=\"382.5\""));
}

TEST(ScalingCurve, ThePageHasATableAndFacts) {
  const std::string page = scaling_curve_page(curve());
  EXPECT_THAT(page, HasSubstr("<tr><td>10</td><td>1</td><td>10.0 [5.0, 15.0]</td>"));
  EXPECT_THAT(page, HasSubstr("20 &lt; 30"));
  EXPECT_THAT(page, HasSubstr("SYNTHETIC: model homes"));
  ScalingCurve real = curve();
  real.synthetic = false;
  real.random.reset();
  EXPECT_THAT(scaling_curve_page(real), Not(HasSubstr("SYNTHETIC")));
  EXPECT_THAT(scaling_curve_page(real), Not(HasSubstr("random")));
}

TEST(ScalingCurve, RefusesNothingAndNoBuilding) {
  EXPECT_THROW(scaling_curve_svg({}), ArgumentError);
  ScalingCurve none = curve();
  none.points.front().buildings = 0;
  EXPECT_THROW(scaling_curve_page(none), ArgumentError);
  ScalingCurve one = curve();
  one.points.resize(1);
  EXPECT_THAT(scaling_curve_svg(one), HasSubstr("cx=\"376.0\""));
}

}  // namespace EN_UNIT
}  // namespace enfilade::report
