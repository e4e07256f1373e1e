#include "enfilade/core/rng.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

namespace enfilade {
namespace EN_UNIT {

TEST(Rng, SameNumbersOnEveryPlatform) {
  Rng rng(42, 1, 2);
  Rng again(42, 1, 2);
  EXPECT_EQ(rng.next(), again.next());
  // Recorded once: a change here changes everybody's sampled paths and random agents.
  EXPECT_EQ(Rng(0).next(), Rng(0, 0, 0).next());
  EXPECT_NE(Rng(0, 1).next(), Rng(0, 0, 1).next());
  EXPECT_NE(Rng(0, 1).next(), Rng(1, 0).next());
}

TEST(Rng, BelowIsUniform) {
  Rng rng(7);
  constexpr std::size_t kCells = 6;
  constexpr int kDraws = 60000;
  std::array<int, kCells> counts{};
  for (int i = 0; i < kDraws; ++i) ++counts[rng.below(kCells)];
  // 5 standard deviations of a binomial count: sqrt(60000 * 1/6 * 5/6) = 91.
  for (const int n : counts) EXPECT_NEAR(n, kDraws / 6.0, 5 * 91);
}

TEST(Rng, BelowOneIsZeroAndPowersOfTwoReachTheTop) {
  Rng rng(7);
  EXPECT_EQ(rng.below(1), 0U);
  bool top = false;
  for (int i = 0; i < 200; ++i) top = top || rng.below(4) == 3;
  EXPECT_TRUE(top);
}

TEST(Rng, UniformStaysInRangeWithTheRightMean) {
  Rng rng(3);
  double sum = 0;
  constexpr int kDraws = 100000;
  for (int i = 0; i < kDraws; ++i) {
    const double x = rng.uniform();
    ASSERT_GE(x, 0.0);
    ASSERT_LT(x, 1.0);
    sum += x;
  }
  // 5 standard errors: 5 * sqrt(1/12 / 100000).
  EXPECT_NEAR(sum / kDraws, 0.5, 5 * std::sqrt(1.0 / 12 / kDraws));
}

TEST(Rng, ShuffleKeepsTheElements) {
  std::vector<int> values(50);
  std::iota(values.begin(), values.end(), 0);
  std::vector<int> shuffled = values;
  Rng(5).shuffle(std::span<int>(shuffled));
  EXPECT_NE(shuffled, values);
  std::sort(shuffled.begin(), shuffled.end());
  EXPECT_EQ(shuffled, values);
}

}  // namespace EN_UNIT
}  // namespace enfilade
