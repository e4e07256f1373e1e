#include "enfilade/render/renderer.h"

#include <gtest/gtest.h>

namespace enfilade::render {
namespace EN_UNIT {

TEST(Pictures, HaveRoomForTheLayersThatAreAskedFor) {
  Pictures pictures;
  const auto layers = static_cast<scan::LayerMask>(1U << index(scan::Layer::kColour) |
                                                   1U << index(scan::Layer::kInstance));
  const Outputs outputs = outputs_into(pictures, layers, 4, 3, 2);
  EXPECT_EQ(pictures.colour.height, 6U);
  ASSERT_TRUE(outputs.colour);
  EXPECT_EQ(outputs.colour->pixels.size(), 2U * 3 * 4 * 3);
  ASSERT_TRUE(outputs.instances);
  EXPECT_EQ(outputs.instances->pixels.data(), pictures.instances.pixels.data());
  EXPECT_FALSE(outputs.depth);
  EXPECT_FALSE(outputs.classes);
  EXPECT_TRUE(pictures.depth.pixels.empty());
}

TEST(Pictures, HaveDepthInQuarterMillimetres) {
  Pictures pictures;
  const Outputs outputs = outputs_into(pictures, scan::kAllLayers, 4, 3);
  EXPECT_EQ(outputs.depth->format, DepthFormat::kQuarterMillimetresUint16);
  EXPECT_EQ(outputs.depth->pixels.size(), 4U * 3 * 2);
}

}  // namespace EN_UNIT
}  // namespace enfilade::render
