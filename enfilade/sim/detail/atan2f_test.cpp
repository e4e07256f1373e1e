#include "enfilade/sim/detail/atan2f.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "enfilade/core/rng.h"
#include "tests/support/reference_navigable.h"

namespace enfilade::sim::detail {
namespace EN_UNIT {

std::uint32_t bits(float x) { return std::bit_cast<std::uint32_t>(x); }

// All signs and exponents alike; every second pair with exponents of a room's lengths.
float draw(Rng& rng, bool ordinary) {
  auto x = static_cast<std::uint32_t>(rng.next());
  if (ordinary) x = (x & 0x807fffffU) | ((118U + (x >> 23U) % 16U) << 23U);
  if ((x & 0x7f800000U) == 0x7f800000U) x &= 0x807fffffU;  // finite
  return std::bit_cast<float>(x);
}

TEST(Atan2f, KnownAngles) {
  constexpr auto kPiFloat = static_cast<float>(kPi);
  EXPECT_EQ(atan2f_fdlibm(1, 1), kPiFloat / 4);
  EXPECT_EQ(atan2f_fdlibm(3, 0), kPiFloat / 2);
  EXPECT_EQ(atan2f_fdlibm(-3, -0.0F), -kPiFloat / 2) << "a zero's sign says nothing here";
  EXPECT_EQ(atan2f_fdlibm(0, -2), kPiFloat);
  EXPECT_EQ(atan2f_fdlibm(-0.0F, -2), -kPiFloat);
  EXPECT_EQ(atan2f_fdlibm(0, -0.0F), kPiFloat);
  EXPECT_EQ(bits(atan2f_fdlibm(0, 0)), bits(0.0F));
  EXPECT_EQ(bits(atan2f_fdlibm(-0.0F, 5)), bits(-0.0F));
}

TEST(Atan2f, HasTheBitsOfItsBranchingTwin) {
  constexpr std::array kOdd{0.0F,      -0.0F,      1.0F,    -1.0F,    0.4375F,  0.6875F, 1.1875F,
                            2.4375F,   -2.4375F,   0x1p25F, -0x1p25F, 0x1p-26F, 1e30F,   -1e30F,
                            0x1p-149F, -0x1p-149F, 1e-38F,  3e38F,    -3e38F};
  for (const float y : kOdd) {
    for (const float x : kOdd) {
      ASSERT_EQ(bits(atan2f_fdlibm(y, x)), bits(tests::reference_atan2f(y, x))) << y << ", " << x;
    }
  }
  Rng rng(1);
  for (int i = 0; i < 2'000'000; ++i) {
    const float y = draw(rng, i % 2 == 0);
    const float x = draw(rng, i % 2 == 0);
    ASSERT_EQ(bits(atan2f_fdlibm(y, x)), bits(tests::reference_atan2f(y, x))) << y << ", " << x;
  }
}

TEST(Atan2f, IsRightToTheLastBits) {
  Rng rng(2);
  for (int i = 0; i < 100'000; ++i) {
    const float y = draw(rng, true);
    const float x = draw(rng, true);
    const double right = std::atan2(static_cast<double>(y), static_cast<double>(x));
    // fdlibm's single-precision functions are good to about one unit of the 24th bit.
    ASSERT_NEAR(static_cast<double>(atan2f_fdlibm(y, x)), right, std::abs(right) * 0x1.8p-23);
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::sim::detail
