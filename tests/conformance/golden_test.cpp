#include "tests/conformance/golden.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "tests/support/graphs.h"

namespace enfilade::tests {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

const std::string kItem =
    R"({"n": 4, "rgb": "rgb_04.png", "depth": "depth_04.png", "scanId": "s", "viewpointId": "v",
        "width": 320, "height": 240, "vfov": 0.8, "heading": 5.9, "elevation": -0.4})";

std::string edited(const std::string& from, const std::string& to) {
  std::string text = R"({"items": [)" + kItem + "]}";
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(Golden, ReadsPoses) {
  const auto poses = parse_golden(edited("items", "items"), "golden.json");
  ASSERT_EQ(poses.size(), 1U);
  EXPECT_EQ(poses[0].scan, "s");
  EXPECT_EQ(poses[0].camera, (Camera{320, 240, Radians(0.8)}));
  EXPECT_EQ(poses[0].elevation, Radians(-0.4));
  EXPECT_EQ(poses[0].depth, "depth_04.png");
}

TEST(Golden, RefusesWhatItCannotUse) {
  const auto expect = [](const std::string& text, const char* says) {
    EXPECT_THAT([&] { (void)parse_golden(text, "golden.json"); },
                ThrowsMessage<InvalidInput>(HasSubstr(says)));
  };
  expect("{}", "has no field \"items\"");
  expect(R"({"items": []})", "$.items: no picture to compare");
  expect(edited("\"width\": 320", "\"width\": 0"), "$.items[0].width: 0 pixels");
  expect(edited("rgb_04.png", "../rgb.png"), "$.items[0].rgb");
  expect(edited("\"vfov\": 0.8", "\"vfov\": 4"), "$.items[0]");
  expect(edited("\"heading\": 5.9", "\"heading\": \"north\""), "$.items[0].heading");
}

image::Image8 grey(std::uint8_t level, std::uint32_t size = 100) {
  image::Image8 picture(size, size, 3);
  std::ranges::fill(picture.pixels, level);
  return picture;
}

TEST(Golden, CountsPixelsByTheirWorstChannel) {
  image::Image8 ours = grey(100);
  ours.pixels[0] = 103;  // one pixel: three levels in one channel, two in another
  ours.pixels[1] = 98;
  ours.pixels[5] = 91;  // another: nine
  ours.pixels[6] = 101;
  const ColourDifference found = compare(ours, grey(100));
  EXPECT_EQ(found.pixels, 10000U);
  EXPECT_EQ(found.largest, 9);
  EXPECT_EQ(found.above_1, 2U);
  EXPECT_EQ(found.above_2, 2U);
  EXPECT_EQ(found.above_8, 1U);
  EXPECT_DOUBLE_EQ(found.mean(), (3 + 2 + 9 + 1) / 30000.0);
}

TEST(Golden, AddsUpPictures) {
  ColourDifference all = compare(grey(1), grey(1));
  all += compare(grey(5), grey(1));
  EXPECT_EQ(all.pixels, 20000U);
  EXPECT_DOUBLE_EQ(all.mean(), 2);
  EXPECT_DOUBLE_EQ(all.share(all.above_2), 0.5);
}

// Each bound is met exactly, then missed by the least that there is.
TEST(Golden, ToleranceIsTheIssues) {
  const GoldenTolerances t;
  const ColourDifference good{10000, 9000, 8, 50, 1, 0};
  const DepthDifference same{10000, 9990, 257};
  EXPECT_TRUE(within(t, good, same));
  ColourDifference bad = good;
  bad.sum = 9001;
  EXPECT_FALSE(within(t, bad, same));
  bad = good;
  bad.above_2 = 2;
  EXPECT_FALSE(within(t, bad, same));
  bad = good;
  bad.largest = 9;
  EXPECT_FALSE(within(t, bad, same));
  EXPECT_FALSE(within(t, good, {10000, 9989, 257}));
}

// A sphere of one colour, 2 m around the only viewpoint.
TEST(Golden, RendersAsTheOldSimulatorDid) {
  scan::Connectivity connectivity = graph::testing::connectivity("s", {{0, 0, 1.5}}, {});
  scan::Panorama panorama;
  for (std::size_t k = 0; k < kCubeFaces; ++k) {
    panorama.colour[k] = image::Image8(8, 8, 3);
    std::ranges::fill(panorama.colour[k].pixels, std::uint8_t{90});
    panorama.depth[k] = image::Image16(8, 8, 1);
    std::ranges::fill(panorama.depth[k].pixels, std::uint16_t{8000});
  }
  const auto panoramas = scan::PanoramaSet::of({std::make_shared<scan::MemoryPanoramas>(
      std::move(connectivity), std::vector<scan::Panorama>{panorama})});
  render::RendererConfig config;
  config.backend = render::Backend::kCpuScalar;
  config.legacy = {true, true};
  const auto renderer =
      render::make_renderer(std::make_shared<render::FaceCache>(panoramas), config);
  const GoldenPose pose{"s", "v0", {33, 33, degrees(90)}, Radians(1), Radians(0.5), "", ""};
  const GoldenPicture picture = render_golden(*renderer, *panoramas, pose);
  EXPECT_EQ(compare(picture.colour, grey(90, 33)).largest, 0);
  // 8-bit buffer: 8000 / 257 = 31.1 is 31 in the middle; at the left edge's middle the ray is
  // 1 / cos = sqrt(1 + (32 / 33)^2) = 1.393 long: 8000 / 1.393 / 257 = 22.3 is 22.
  EXPECT_EQ(*picture.depth.at(16, 16), 31 * 257);
  EXPECT_EQ(*picture.depth.at(0, 16), 22 * 257);
  EXPECT_THROW((void)render_golden(*renderer, *panoramas, {"s", "v1", {}, {}, {}, "", ""}),
               LookupError);
}

TEST(Golden, ShowsWhereDepthDiffers) {
  image::Image16 ours(2, 1, 1), golden(2, 1, 1);
  ours.pixels = {257, 514};
  golden.pixels = {257, 257};
  const DepthDifference found = compare(ours, golden);
  EXPECT_EQ(found.identical, 1U);
  EXPECT_EQ(found.largest, 257);
  const image::Image8 sheet = side_by_side(ours, golden);
  EXPECT_EQ(sheet.width, 6U);
  EXPECT_EQ(*sheet.at(4, 0), 0);
  EXPECT_GE(*sheet.at(5, 0), 64);
}

TEST(Golden, ColourDifferenceIsMagnified) {
  const image::Image8 sheet = side_by_side(grey(10), grey(12));
  EXPECT_EQ(sheet.width, 300U);
  EXPECT_EQ(*sheet.at(0, 0), 10);
  EXPECT_EQ(*sheet.at(100, 0), 12);
  EXPECT_EQ(*sheet.at(200, 0), 64);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
