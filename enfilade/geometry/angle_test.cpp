#include "enfilade/geometry/angle.h"

#include <gtest/gtest.h>

namespace enfilade {
namespace EN_UNIT {

TEST(WrapHeading, KeepsWhatIsInRangeToTheBit) {
  for (const double h : {0.0, 1e-300, 0.1, 3.0, 6.28}) EXPECT_EQ(wrap_heading(Radians(h)).value, h);
}

TEST(WrapHeading, WrapsBothWays) {
  EXPECT_EQ(wrap_heading(Radians(-1)).value, 2 * kPi - 1);
  EXPECT_EQ(wrap_heading(Radians(2 * kPi)).value, 0.0);
  // fmod is exact, so these are too.
  EXPECT_EQ(wrap_heading(Radians(100)).value, std::fmod(100, 2 * kPi));
  EXPECT_EQ(wrap_heading(Radians(-100)).value, std::fmod(-100, 2 * kPi) + 2 * kPi);
  EXPECT_EQ(wrap_heading(Radians(1e18)).value, std::fmod(1e18, 2 * kPi));
}

TEST(WrapHeading, ATinyNegativeGivesAFullTurnAsMatterSimDoes) {
  EXPECT_EQ(wrap_heading(Radians(-1e-17)).value, 2 * kPi);
}

TEST(WrapDifference, TakesTheShorterWay) {
  EXPECT_NEAR(wrap_difference(Radians(1.5 * kPi)).value, -0.5 * kPi, 1e-15);  // two roundings
  EXPECT_EQ(wrap_difference(Radians(-kPi)).value, kPi);
  EXPECT_EQ(wrap_difference(Radians(0.25)).value, 0.25);
}

TEST(Degrees, ComeBack) { EXPECT_NEAR(to_degrees(degrees(30)), 30, 1e-14); }  // two roundings

}  // namespace EN_UNIT
}  // namespace enfilade
