#include "enfilade/core/half.h"

#include <gtest/gtest.h>
#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

namespace enfilade {
namespace EN_UNIT {

// From the definition: (-1)^s (1 + m / 1024) 2^(e - 15), and (-1)^s (m / 1024) 2^-14 for e = 0.
double value_of(std::uint16_t half) {
  const int exponent = half >> 10 & 31, mantissa = half & 1023;
  const double magnitude =
      exponent == 0 ? std::ldexp(mantissa, -24) : std::ldexp(1024 + mantissa, exponent - 25);
  return (half & 0x8000) != 0 ? -magnitude : magnitude;
}

bool is_finite(std::uint16_t half) { return (half >> 10 & 31) != 31; }

std::vector<std::uint16_t> all_finite_halves() {
  std::vector<std::uint16_t> halves;
  for (unsigned bits = 0; bits < 65536; ++bits) {
    const auto half = static_cast<std::uint16_t>(bits);
    if (is_finite(half)) halves.push_back(half);
  }
  return halves;
}

const std::byte* bytes_of(const std::vector<std::uint16_t>& halves) {
  return std::as_bytes(std::span(halves)).data();
}

TEST(Half, EachIsReadExactlyAndGoesBackToItself) {
  const auto halves = all_finite_halves();
  std::vector<float> floats(halves.size());
  EXPECT_TRUE(copy_halves(bytes_of(halves), floats));
  for (std::size_t i = 0; i < halves.size(); ++i) {
    ASSERT_EQ(floats[i], value_of(halves[i])) << halves[i];
    ASSERT_EQ(std::signbit(floats[i]), (halves[i] & 0x8000) != 0);
    ASSERT_EQ(to_half(floats[i]), halves[i]);
  }
}

TEST(Half, BetweenTwoTheNearestIsTakenAndTheEvenOneInTheMiddle) {
  for (std::uint16_t half = 0; is_finite(static_cast<std::uint16_t>(half + 1)); ++half) {
    const auto next = static_cast<std::uint16_t>(half + 1);
    // Exact: a float has 13 bits more than a half.
    const auto middle = static_cast<float>((value_of(half) + value_of(next)) / 2);
    ASSERT_EQ(to_half(middle), half % 2 == 0 ? half : next) << half;
    ASSERT_EQ(to_half(std::nextafter(middle, 0.0F)), half);
    ASSERT_EQ(to_half(std::nextafter(middle, 1e6F)), next);
    ASSERT_EQ(to_half(-middle), to_half(middle) | 0x8000);
  }
}

TEST(Half, WhatIsTooLargeIsInfinite) {
  EXPECT_EQ(to_half(65519.996F), 0x7bff) << "65504, the largest";
  EXPECT_EQ(to_half(65520.0F), 0x7c00);
  EXPECT_EQ(to_half(-1e30F), 0xfc00);
  EXPECT_EQ(to_half(std::numeric_limits<float>::infinity()), 0x7c00);
  EXPECT_GT(to_half(std::numeric_limits<float>::quiet_NaN()) & 0x7fff, 0x7c00);
  EXPECT_EQ(to_half(std::numeric_limits<float>::denorm_min()), 0);
}

// Wherever it is, in a whole block or behind the last one.
TEST(Half, OneNumberThatIsNoneIsSeen) {
  for (std::size_t at = 0; at < 37; ++at) {
    std::vector<float> out(37);
    for (const unsigned none : {0x7c00U, 0xfc00U, 0x7e00U, 0xfc01U}) {
      std::vector<std::uint16_t> halves(37, 0x7bff);
      EXPECT_TRUE(copy_halves(bytes_of(halves), out));
      halves[at] = static_cast<std::uint16_t>(none);
      EXPECT_FALSE(copy_halves(bytes_of(halves), out)) << at;
    }
    for (const float none : {INFINITY, -INFINITY, NAN}) {
      std::vector<float> floats(37, std::numeric_limits<float>::max());
      EXPECT_TRUE(all_finite(floats));
      floats[at] = none;
      EXPECT_FALSE(copy_floats(std::as_bytes(std::span(floats)).data(), out)) << at;
    }
  }
}

TEST(Half, NeedNoAlignment) {
  const auto halves = all_finite_halves();
  std::vector<std::byte> shifted(2 * halves.size() + 1);
  std::memcpy(shifted.data() + 1, halves.data(), 2 * halves.size());
  std::vector<float> straight(halves.size()), odd(halves.size());
  copy_halves(bytes_of(halves), straight);
  copy_halves(shifted.data() + 1, odd);
  EXPECT_EQ(odd, straight);
}

}  // namespace EN_UNIT
}  // namespace enfilade
