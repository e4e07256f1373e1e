#include "enfilade/dataset/views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <span>
#include <string>

#include "enfilade/core/errors.h"
#include "enfilade/scan/store.h"
#include "tests/support/made_panoramas.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::dataset {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// Two viewpoints of scan "made", of which the second has no pictures.
class Views : public ::testing::Test {
 protected:
  Views() : made_("dataset_views"), data_((pack_into(made_.path()), made_.path())) {}

  static void pack_into(const std::filesystem::path& folder) {
    const scan::MemoryPanoramas panoramas(scan::testing::row_of_viewpoints("made", 2),
                                          {render::testing::made_panorama(32), scan::Panorama()});
    scan::pack(panoramas, folder, {.colour = scan::ColourCoding::kRaw});
  }

  tests::TemporaryFolder made_;
  Dataset data_;
};

TEST_F(Views, AreThoseOfARenderer) {
  const Camera camera{48, 36, 60_deg};
  const NamedView named{"made", "v0", 70_deg, -10_deg};
  const render::View view = find_view(data_, named);
  EXPECT_EQ(view.heading, 70_deg);
  image::Image8 colour(48, 36, 3);
  image::Image16 depth(48, 36, 1);
  image::Image32 instances(48, 36, 1);
  render::Outputs outputs;
  outputs.colour = render::ColourOutput{
      render::ColourFormat::kRgb8, {}, std::as_writable_bytes(std::span(colour.pixels))};
  outputs.depth =
      render::DepthOutput{render::DepthFormat::kQuarterMillimetresUint16, render::DepthMeasure::kZ,
                          std::as_writable_bytes(std::span(depth.pixels))};
  outputs.instances = render::InstanceOutput{instances.pixels};
  render::make_renderer(data_.faces())->render(camera, {&view, 1}, outputs);
  EXPECT_EQ(render_colour(data_, named, camera), colour);
  EXPECT_EQ(render_colour(data_, view, camera), colour);
  EXPECT_EQ(render_depth(data_, named, camera), depth);
  EXPECT_EQ(render_instances(data_, view, camera), instances);
}

TEST_F(Views, APanoramaLooksAlongItsHeadingInTheMiddle) {
  const image::Image8 all = render_panorama(data_, NamedView{"made", "v0", 90_deg, {}}, 64);
  EXPECT_EQ(all.width, 64U);
  EXPECT_EQ(all.height, 32U);
  const image::Image8 ahead =
      render_colour(data_, NamedView{"made", "v0", 90_deg, {}}, {3, 3, 5_deg});
  for (std::size_t c = 0; c < 3; ++c) {
    // Colours of directions differ by 127.5 a radian at most; the pixels by 0.05 rad: 7 levels.
    EXPECT_NEAR(all.at(32, 16)[c], ahead.at(1, 1)[c], 8) << c;
  }
}

TEST_F(Views, SayWhatIsNotThere) {
  EXPECT_TRUE(has_colour(data_, ScanIndex(0), ViewpointIndex(0)));
  EXPECT_FALSE(has_colour(data_, ScanIndex(0), ViewpointIndex(1)));
  EXPECT_THAT(
      [&] {
        (void)render_colour(data_, NamedView{"made", "v9", {}, {}});
      },
      ThrowsMessage<LookupError>(HasSubstr("v9")));
  EXPECT_THAT(
      [&] {
        (void)render_colour(data_, NamedView{"made", "v1", {}, {}});
      },
      ThrowsMessage<LookupError>(HasSubstr("v1")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::dataset
