#include "enfilade/sim/detail/navigable_views.h"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <vector>

#include "enfilade/core/rng.h"

namespace enfilade::sim::detail {
namespace EN_UNIT {

std::uint32_t bits(float x) { return std::bit_cast<std::uint32_t>(x); }

void expect_defined_bits(const std::vector<double>& headings) {
  std::vector<FloorDirection> fast(headings.size());
  compute_directions(headings, fast);
  for (std::size_t i = 0; i < headings.size(); ++i) {
    const FloorDirection defined = direction_of(Radians(headings[i]));
    ASSERT_EQ(bits(fast[i].x), bits(defined.x)) << headings[i];
    ASSERT_EQ(bits(fast[i].y), bits(defined.y)) << headings[i];
  }
}

TEST(CameraDirection, PointsAlongTheAxes) {
  const FloorDirection right = direction_of(degrees(90));
  EXPECT_EQ(right.x, 1);
  EXPECT_NEAR(right.y, 0, 1e-16);  // pi/2 itself is rounded
  EXPECT_EQ(direction_of(Radians(0)).y, 1);
  EXPECT_EQ(direction_of(degrees(180)).y, -1);
}

TEST(CameraDirection, FastOnesAreTheDefinedOnes) {
  Rng rng(1);
  std::vector<double> headings;
  for (int i = 0; i < 500'000; ++i) headings.push_back(rng.uniform() * (2 * kPi));
  expect_defined_bits(headings);
}

TEST(CameraDirection, FastOnesAreTheDefinedOnesWhereRoundingIsInDoubt) {
  // Around multiples of 15 degrees sines and cosines are 0, 1/2 and 1; the nearer, the harder.
  std::vector<double> headings{0, 2 * kPi, 1e-300};
  for (int step = 0; step <= 24; ++step) {
    const double middle = step * (kPi / 12);
    for (double off = 1; off > 1e-18; off *= 0.7) {
      for (const double heading : {middle - off, middle, middle + off}) {
        if (heading >= 0 && heading <= 2 * kPi) headings.push_back(heading);
      }
    }
  }
  expect_defined_bits(headings);
}

TEST(CameraDirection, AnyNumberAtOnce) {
  for (std::size_t n = 0; n < 20; ++n) expect_defined_bits(std::vector<double>(n, 1.25));
}

}  // namespace EN_UNIT
}  // namespace enfilade::sim::detail
