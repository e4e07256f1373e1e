#include "bench/render_speed.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "apps/common/program.h"

namespace enfilade::bench {
namespace EN_UNIT {

const Buildings& buildings() {
  static const Buildings kBuildings = synthetic_buildings();
  return kBuildings;
}

constexpr Camera kSmall{64, 48, degrees(60)};

TEST(OutputMemory, HoldsWhatIsNamed) {
  const OutputMemory memory("f16+depth+class+instance", kSmall, 3);
  const render::Outputs& outputs = memory.outputs();
  ASSERT_TRUE(outputs.colour && outputs.depth && outputs.classes && outputs.instances);
  EXPECT_EQ(outputs.colour->format, render::ColourFormat::kPlanarFloat16);
  EXPECT_EQ(outputs.colour->pixels.size(), 64U * 48 * 3 * 3 * 2);
  EXPECT_EQ(outputs.depth->pixels.size(), 64U * 48 * 3 * 2);
  const OutputMemory depth("depth", kSmall, 1);
  EXPECT_FALSE(depth.outputs().colour);
  for (const char* wrong : {"", "rgb+", "rgb+f16", "smell", "rgb,depth"}) {
    EXPECT_THROW(OutputMemory(wrong, kSmall, 1), apps::UsageError) << wrong;
  }
}

TEST(Walk, IsTheSameEachTimeAndGetsAround) {
  Walk a(buildings(), kSmall, 4), b(buildings(), kSmall, 4);
  std::set<ViewpointIndex> seen;
  std::set<int> headings;
  for (int i = 0; i < 1000; ++i) {
    for (std::size_t k = 0; k < 4; ++k) {
      EXPECT_EQ(a.views()[k].viewpoint, b.views()[k].viewpoint);
      EXPECT_EQ(a.views()[k].heading, b.views()[k].heading);
      seen.insert(a.views()[k].viewpoint);
      headings.insert(static_cast<int>(std::lround(to_degrees(a.views()[k].heading))) % 360);
      EXPECT_LE(std::abs(to_degrees(a.views()[k].elevation)), 30.001);
    }
    a.step();
    b.step();
  }
  EXPECT_EQ(seen.size(), 9U);       // all of the building
  EXPECT_EQ(headings.size(), 12U);  // in steps of 30 degrees
}

TEST(Measure, CountsFramesAndWhatWasDecoded) {
  const BenchSettings settings{.gl_device = {}, .frames = 24, .repetitions = 3};
  const Measurement hot = measure(buildings(), {kSmall, "rgb", 4, 1, false}, settings);
  EXPECT_EQ(hot.per_second.size(), 3U);
  EXPECT_TRUE(std::ranges::is_sorted(hot.per_second));
  EXPECT_GT(hot.median(), 0);
  EXPECT_GT(hot.cpu_seconds, 0);
  EXPECT_EQ(hot.faces_per_frame, 0);
  EXPECT_EQ(hot.decoding_share, 0);
  const Measurement cold = measure(buildings(), {kSmall, "rgb", 4, 1, true}, settings);
  EXPECT_GT(cold.faces_per_frame, 0);
  EXPECT_GT(cold.decoding_share, 0);
  EXPECT_LE(cold.decoding_share, 1);
  EXPECT_GT(cold.cpu_seconds, hot.cpu_seconds);  // decodes in the same thread
}

TEST(Measure, SweepDrawsEveryView) {
  const BenchSettings settings{.gl_device = {}, .repetitions = 1};
  const Measurement m = measure_sweep(buildings(), {kSmall, "rgb", 36, 1, true}, settings);
  // Each of nine panoramas is looked at all around: six faces for 36 views.
  EXPECT_DOUBLE_EQ(m.faces_per_frame, 6.0 / 36);
}

TEST(Measure, WalkMemoryGrowsWithTheCache) {
  if (memory_now().anonymous == 0) GTEST_SKIP() << "no RssAnon in /proc/self/status";
  const BenchSettings settings{.gl_device = {}, .frames = 50, .repetitions = 1};
  const WalkMemory m = measure_walk_memory(buildings(), {kSmall, "rgb", 1, 1, true}, settings);
  EXPECT_EQ(m.frames, 50U);
  EXPECT_GT(m.viewpoints_seen, 1U);
  EXPECT_GT(m.most.anonymous, 0U);
  EXPECT_GE(m.most.peak, m.most.anonymous);
}

}  // namespace EN_UNIT
}  // namespace enfilade::bench
