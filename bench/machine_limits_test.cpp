#include "bench/machine_limits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <vector>

#include "bench/cpu_time.h"

namespace enfilade::bench {
namespace EN_UNIT {

TEST(MachineLimits, AreThoseOfAComputer) {
  const MachineLimits limits = measure_machine_limits();
  // Wide: a debug build's chain goes through memory. Who mixes up units is off by a thousand.
  EXPECT_GT(limits.clock_hz, 5e7);
  EXPECT_LT(limits.clock_hz, 1e10);
  EXPECT_GT(limits.memory.bytes, limits.cache.bytes);
  for (const MemoryRates& rates : {limits.cache, limits.memory}) {
    for (const double rate :
         {rates.read, rates.read_pieces, rates.write, rates.write_past_caches}) {
      EXPECT_GT(rate, 2e7);
      EXPECT_LT(rate, 2e12);
    }
  }
}

// A picture of 90 degrees shows a sixth of all directions, as a face does; turned ones show more
// small texels or fewer large ones.
TEST(TexelsSeen, OfASixthOfTheDirectionsAreAboutAFace) {
  constexpr std::uint32_t kSize = 32;
  const TexelsSeen seen = texels_seen({4 * kSize, 4 * kSize, degrees(90)}, kSize);
  EXPECT_NEAR(seen.nearest / (kSize * kSize), 1, 0.2);
  EXPECT_GT(seen.linear, seen.nearest);
}

TEST(TexelsSeen, AreOneAPixelAtMostWhereNotFiltered) {
  EXPECT_LE(texels_seen({32, 32, degrees(90)}, 512).nearest, 32 * 32);
}

TEST(TexelsSeen, OfANeedleAreFourAtMost) {
  const TexelsSeen seen = texels_seen({1, 1, degrees(1)}, 512);
  EXPECT_DOUBLE_EQ(seen.nearest, 1);
  EXPECT_GT(seen.linear, 1);
  EXPECT_LE(seen.linear, 4);
}

TEST(TexelsSeen, GrowWithTheFace) {
  const Camera camera{640, 480, degrees(60)};
  const TexelsSeen small = texels_seen(camera, 64), large = texels_seen(camera, 128);
  EXPECT_NEAR(large.linear / small.linear, 4, 0.3);
  EXPECT_NEAR(large.nearest / large.linear, 1, 0.1);  // magnified: each texel is some pixel's
}

TEST(MemoryBound, AddsReadingAndTheQuickestWriting) {
  std::vector<std::byte> colour(3 * 2), depth(2 * 2);
  render::Outputs outputs;
  outputs.colour = render::ColourOutput{render::ColourFormat::kRgb8, {}, colour};
  outputs.depth = render::DepthOutput{render::DepthFormat::kQuarterMillimetresUint16,
                                      render::DepthMeasure::kZ, depth};
  const Camera camera{1, 1, degrees(1)};
  const PictureTraffic traffic = picture_traffic(camera, 512, outputs, 2);
  EXPECT_DOUBLE_EQ(traffic.output, 5);
  EXPECT_DOUBLE_EQ(traffic.texels, 3 * texels_seen(camera, 512).linear + 2);

  const MachineLimits limits{.cache = {1, 10, 8, 5, 4}, .memory = {1, 5, 2, 4, 20}};
  EXPECT_DOUBLE_EQ(memory_bound({16, 40}, limits.cache, limits), 16.0 / 10 + 40.0 / 20);
  EXPECT_DOUBLE_EQ(memory_bound({16, 40}, limits.memory, limits), 16.0 / 5 + 40.0 / 20);
}

TEST(CpuTime, GrowsWithWorkAlone) {
  const PinnedThread pinned;
  const double thread = thread_cpu_seconds(), process = process_cpu_seconds();
  volatile double x = 1;
  while (thread_cpu_seconds() - thread < 0.01) x = std::sqrt(x + 1);
  EXPECT_GE(process_cpu_seconds() - process, 0.009);  // the two clocks are not read at once
}

}  // namespace EN_UNIT
}  // namespace enfilade::bench
