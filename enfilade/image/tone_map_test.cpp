#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <limits>

#include "enfilade/image/codecs.h"

namespace enfilade::image {
namespace EN_UNIT {

ImageF greys(std::initializer_list<float> values) {
  ImageF picture(static_cast<std::uint32_t>(values.size()), 1, 3);
  std::size_t i = 0;
  for (const float value : values) {
    for (int c = 0; c < 3; ++c) picture.pixels[i++] = value;
  }
  return picture;
}

TEST(ToneMap, MakesTheMedianMidGreyWhateverTheUnits) {
  // sRGB of 18 % is 0.4613, that is 117.6 of 255.
  for (const float unit : {1e-3F, 1.0F, 1e3F}) {
    const Image8 picture = tone_map(greys({0.1F * unit, 2 * unit, 90 * unit}));
    EXPECT_EQ(picture.pixels[3], 118);
    EXPECT_LT(picture.pixels[0], 40);
    EXPECT_GT(picture.pixels[6], 250);
  }
}

TEST(ToneMap, TakesAnExposureInStops) {
  // Below the shoulder it is sRGB alone: 0.05 -> 0.2478, 63.2 of 255; two stops up, 0.2 -> 0.4845.
  EXPECT_EQ(tone_map(greys({0.05F}), 0).pixels[0], 63);
  EXPECT_EQ(tone_map(greys({0.05F}), 2).pixels[0], 124);
}

TEST(ToneMap, NeverTurnsBrighterIntoDarker) {
  ImageF ramp(2000, 1, 3);
  for (std::size_t i = 0; i < ramp.pixels.size(); ++i) {
    ramp.pixels[i] = std::exp2(static_cast<float>(i / 3) / 100 - 10);  // 2^-10 .. 2^10
  }
  const Image8 picture = tone_map(ramp, 0);
  EXPECT_TRUE(std::ranges::is_sorted(picture.pixels));
  EXPECT_EQ(picture.pixels.back(), 255);
}

TEST(ToneMap, TakesAnyNumbers) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  const Image8 odd = tone_map(greys({0, -1, kInfinity, std::nanf(""), 1}));
  EXPECT_THAT(odd.pixels,
              ::testing::ElementsAre(0, 0, 0, 0, 0, 0, 255, 255, 255, 0, 0, 0, 118, 118, 118));
  EXPECT_THAT(tone_map(greys({0, 0})).pixels, ::testing::Each(0));
  EXPECT_THROW(tone_map(ImageF(1, 1, 1)), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::image
