#include <gtest/gtest.h>

#include <cmath>

#include "enfilade/core/errors.h"
#include "tests/support/made_panoramas.h"

namespace enfilade::render {
namespace EN_UNIT {

TEST(Equirectangular, EachPixelShowsItsDirection) {
  const auto cache = testing::made_cache(128);
  constexpr std::uint32_t kWidth = 200, kHeight = 100;
  const View view{ScanIndex(0), ViewpointIndex(0), degrees(70), Radians(0)};
  testing::Pictures out({kWidth, kHeight, degrees(90)}, 1);
  render_equirectangular(cache, view, kWidth, kHeight, out.outputs());
  for (std::uint32_t i = 0; i < kHeight; ++i) {
    for (std::uint32_t j = 0; j < kWidth; ++j) {
      const double heading = degrees(70).value + ((j + 0.5) / kWidth - 0.5) * 2 * kPi;
      const double elevation = (0.5 - (i + 0.5) / kHeight) * kPi;
      // World to panorama of testing's poses: x = x, y = -z, z = y.
      const Vec3d d{std::cos(elevation) * std::sin(heading), -std::sin(elevation),
                    std::cos(elevation) * std::cos(heading)};
      const auto expected = testing::direction_colour(d);
      const std::size_t p = std::size_t{i} * kWidth + j;
      for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(out.channel(p, c), expected[c], 1.6);
      // A texel of 1/64 rad shifts the distance of slanting walls.
      const double distance = testing::Room().distance(d);
      ASSERT_NEAR(static_cast<double>(out.depth[p]), distance, 0.05 * distance);
      ASSERT_EQ(out.classes[p], index(project_to_cube(d).face) + 1);
    }
  }
}

TEST(Equirectangular, ThreadsDoNotChangeABit) {
  const auto cache = testing::made_cache(16);
  const View view{ScanIndex(0), ViewpointIndex(0), degrees(10), Radians(0)};
  testing::Pictures a({600, 300, degrees(90)}, 1), b({600, 300, degrees(90)}, 1);
  render_equirectangular(cache, view, 600, 300, a.outputs(), 1);
  render_equirectangular(cache, view, 600, 300, b.outputs(), 2);
  EXPECT_EQ(a, b);
}

TEST(Equirectangular, RefusesWrongSizes) {
  const auto cache = testing::made_cache(16);
  const View view{ScanIndex(0), ViewpointIndex(0), degrees(10), Radians(0)};
  testing::Pictures out({20, 10, degrees(90)}, 1);
  EXPECT_THROW(render_equirectangular(cache, view, 21, 10, out.outputs()), ArgumentError);
  EXPECT_THROW(render_equirectangular(cache, view, 0, 10, out.outputs()), ArgumentError);
  EXPECT_THROW(render_equirectangular(nullptr, view, 20, 10, out.outputs()), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::render
