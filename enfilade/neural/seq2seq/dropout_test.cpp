#include "enfilade/neural/seq2seq/kernels.h"

#include <gtest/gtest.h>
#include <cstdint>
#include <vector>

namespace enfilade::neural::seq2seq {
namespace EN_UNIT {

// 100,000 bits: the share errs by 0.0016 (1 sigma).
TEST(RolloutDropout, KeepsTheShareThatIsAsked) {
  for (const double probability : {0.5, 0.3, 0.0001}) {
    double kept = 0;
    std::vector<std::uint64_t> mask(mask_words(100));
    for (std::uint32_t row = 0; row < 1000; ++row) {
      draw_mask({1, 0, probability}, DropoutSite::kContext, {2, row}, 100, mask);
      for (std::size_t i = 0; i < 100; ++i) {
        kept += static_cast<double>(mask[i / 64] >> (i % 64) & 1U);
      }
    }
    EXPECT_NEAR(kept / 1e5, 1 - probability, 0.008);
  }
}

TEST(RolloutDropout, EveryCounterNamesAnotherMask) {
  const auto mask = [](std::uint64_t seed, std::uint64_t stream, DropoutSite site, MaskRow at) {
    std::vector<std::uint64_t> words(4);
    draw_mask({seed, stream, 0.5}, site, at, 256, words);
    return words;
  };
  const auto first = mask(1, 2, DropoutSite::kWords, {3, 4});
  EXPECT_EQ(mask(1, 2, DropoutSite::kWords, {3, 4}), first);
  EXPECT_NE(mask(2, 2, DropoutSite::kWords, {3, 4}), first);
  EXPECT_NE(mask(1, 3, DropoutSite::kWords, {3, 4}), first);
  EXPECT_NE(mask(1, 2, DropoutSite::kContext, {3, 4}), first);
  EXPECT_NE(mask(1, 2, DropoutSite::kWords, {4, 4}), first);
  EXPECT_NE(mask(1, 2, DropoutSite::kWords, {3, 5}), first);
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::seq2seq
