#include "enfilade/image/tone.h"

#include <gtest/gtest.h>

namespace enfilade::image {
namespace EN_UNIT {

TEST(Shoulder, IsStraightThenBendsTowardsOne) {
  EXPECT_EQ(shoulder(-0.5), 0.0);
  EXPECT_EQ(shoulder(kMidGrey<double>), 0.18);
  EXPECT_EQ(shoulder(0.4), 0.4);
  // One knee's rest above the knee: 0.4 + 0.6 (1 - 1 / e).
  EXPECT_NEAR(shoulder(1.0), 0.4 + 0.6 * (1 - 0.36787944), 1e-8);
  EXPECT_LT(shoulder(10.0), 1.0);
  EXPECT_GT(shoulder(10.0), 0.9999);
  EXPECT_LE(shoulder(1e30F), 1.0F);
}

TEST(Shoulder, HasNoStepAndNoCornerAtTheKnee) {
  constexpr double kStep = 1e-6;
  const double below = shoulder(0.4) - shoulder(0.4 - kStep);
  const double above = shoulder(0.4 + kStep) - shoulder(0.4);
  // The second derivative above is -1 / 0.6, so that the slopes differ by less than 2 steps.
  EXPECT_NEAR(above / kStep, below / kStep, 2 * kStep);
}

TEST(Srgb, HasItsPublishedValues) {
  EXPECT_EQ(srgb_from_linear(0.0), 0.0);
  EXPECT_NEAR(srgb_from_linear(0.002), 0.02584, 1e-12);   // 12.92 x
  EXPECT_NEAR(srgb_from_linear(0.18), 0.46135613, 1e-8);  // 1.055 * 0.18^(1 / 2.4) - 0.055
  EXPECT_NEAR(srgb_from_linear(1.0), 1.0, 1e-15);
  EXPECT_NEAR(linear_from_srgb(0.5), 0.21404114, 1e-8);  // (0.555 / 1.055)^2.4
  EXPECT_NEAR(linear_from_srgb(0.04), 0.04 / 12.92, 1e-15);
  EXPECT_EQ(srgb8_from_linear(kMidGrey<float>), 118);  // 117.6
}

TEST(Srgb, CutsOffWhatNoScreenShows) {
  EXPECT_EQ(srgb8_from_linear(-1.0F), 0);
  EXPECT_EQ(srgb8_from_linear(7.0), 255);
}

TEST(Srgb, GivesEachByteBack) {
  for (int i = 0; i < 256; ++i) {
    EXPECT_EQ(srgb8_from_linear(linear_from_srgb(static_cast<float>(i) / 255)), i);
    EXPECT_EQ(srgb8_from_linear(linear_from_srgb(i / 255.0)), i);
  }
}

TEST(Luminance, OfWhiteIsOne) {
  EXPECT_NEAR(luminance(1.0, 1.0, 1.0), 1, 1e-15);
  EXPECT_EQ(luminance(0.0F, 2.0F, 0.0F), 2 * 0.7152F);
}

}  // namespace EN_UNIT
}  // namespace enfilade::image
