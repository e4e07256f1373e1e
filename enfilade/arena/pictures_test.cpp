#include "enfilade/arena/pictures.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/arena/world.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"
#include "enfilade/scan/store.h"
#include "tests/support/panoramas.h"
#include "tests/support/refusal.h"
#include "tests/support/room_world.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::arena {
namespace EN_UNIT {

using ::testing::HasSubstr;
using tests::refusal;

/// A row of viewpoints to the east with panoramas; an episode that starts at v1 and looks there.
class ArenaPictures : public ::testing::Test {
 protected:
  ArenaPictures() : folder_("arena_pictures") {
    for (const char* name : {"connectivity", "r2r", "store"}) make_folder(folder_.path() / name);
    const scan::Connectivity row = scan::testing::row_of_viewpoints("row", 3);
    write_file_atomically(folder_.path() / "connectivity/scans.txt", "row\n");
    write_file_atomically(folder_.path() / "connectivity/row_connectivity.json",
                          scan::to_json(row));
    std::vector<scan::Panorama> panoramas;
    for (std::uint64_t v = 0; v < 3; ++v) panoramas.push_back(scan::testing::panorama(32, v));
    scan::pack(scan::MemoryPanoramas(row, std::move(panoramas)), folder_.path() / "store", {});
    tasks::Annotations split{"val_seen", "", {}};
    split.paths.push_back({1, "row", degrees(90), {"v1", "v2"}, 1.0, {"Go on."}});
    write_file_atomically(folder_.path() / "r2r/R2R_val_seen.json", to_json(split));
    data_ = std::make_shared<const dataset::Dataset>(folder_.path());
    world_.emplace(std::make_shared<const tasks::EpisodeSet>(data_->episodes("val_seen")));
  }
  tests::TemporaryFolder folder_;
  std::shared_ptr<const dataset::Dataset> data_;
  std::optional<GraphWorld> world_;
};

image::Image8 decoded(const std::string& jpeg) {
  return image::decode_jpeg({reinterpret_cast<const std::uint8_t*>(jpeg.data()), jpeg.size()},
                            "a picture");
}

TEST_F(ArenaPictures, AStripHasTheNamesOfItsPlaces) {
  const auto session = world_->start_on_graph(0);  // one ahead and one behind
  const auto orders = order_pictures(*session, PictureKind::kStrip, 128);
  ASSERT_EQ(orders.size(), 1U);
  EXPECT_EQ(orders[0].marks.size(), 2U);
  PictureMaker painter({.data = data_});
  const std::string jpeg = painter.draw(orders[0]);
  const image::Image8 strip = decoded(jpeg);
  EXPECT_EQ(strip.width, 512U);
  EXPECT_EQ(strip.height, 128U);
  EXPECT_EQ(painter.draw(orders[0]), jpeg);
  // v2 is ahead (the episode looks east), v0 behind: in the middles of the second and fourth part.
  auto plain = orders[0];
  plain.marks.clear();
  const image::Image8 without = decoded(painter.draw(plain));
  const auto differs = [&](std::size_t x) {
    int sum = 0;
    for (int c = 0; c < 3; ++c) sum += std::abs(strip.at(x, 64)[c] - without.at(x, 64)[c]);
    return sum > 100;
  };
  EXPECT_TRUE(differs(192 - 4) || differs(192 + 4));
  EXPECT_TRUE(differs(448 - 4) || differs(448 + 4));
  EXPECT_FALSE(differs(64));
  EXPECT_FALSE(differs(320));
}

TEST_F(ArenaPictures, APlaceHasAPictureThatLooksThere) {
  const auto session = world_->start_on_graph(0);
  const auto orders = order_pictures(*session, PictureKind::kPlaces, 96);
  ASSERT_EQ(orders.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(orders[k].caption, session->observation().places[k].name);
  }
  PictureMaker painter({.data = data_});
  EXPECT_EQ(decoded(painter.draw(orders[0])).width, 96U);
  EXPECT_TRUE(order_pictures(*session, PictureKind::kNone).empty());
  session->call({"stop", ""});
  EXPECT_TRUE(order_pictures(*session, PictureKind::kStrip).empty());
}

TEST(FloorPictures, LookAheadOrAllAround) {
  FloorWorld world = testing::room();
  const auto session = world.start(0);
  const auto strip = order_pictures(*session, PictureKind::kStrip, 64);
  const auto ahead = order_pictures(*session, PictureKind::kPlaces, 64);
  ASSERT_EQ(strip.size(), 1U);
  ASSERT_EQ(ahead.size(), 1U);
  EXPECT_TRUE(strip[0].marks.empty());
  EXPECT_EQ(ahead[0].caption, "ahead");
  int opened = 0;
  PictureMaker painter({.data = nullptr, .scene_of = [&opened](const std::string& scan) {
                          EXPECT_EQ(scan, "room");
                          ++opened;
                          return continuous::Scene::photographed(testing::room_tracer());
                        }});
  const image::Image8 around = decoded(painter.draw(strip[0]));
  const image::Image8 one = decoded(painter.draw(ahead[0]));
  EXPECT_EQ(around.width, 256U);
  EXPECT_EQ(one.width, 64U);
  EXPECT_EQ(opened, 1);
  // The second quarter is what is ahead, but for what JPEG makes of it.
  for (std::size_t x = 0; x < 64; x += 9) {
    EXPECT_NEAR(around.at(64 + x, 20)[0], one.at(x, 20)[0], 12) << x;
  }
  PictureMaker blind{ViewSources()};
  EXPECT_THAT(refusal<ArgumentError>([&] { blind.draw(strip[0]); }), HasSubstr("no meshes"));
}

TEST_F(ArenaPictures, KeysNameWhatIsShown) {
  const auto session = world_->start_on_graph(0);
  const auto orders = order_pictures(*session, PictureKind::kPlaces, 96);
  EXPECT_EQ(orders[1].key().substr(0, 12), "view/row/v1/");
  EXPECT_NE(orders[0].key(), orders[1].key());
  EXPECT_NE(order_pictures(*session, PictureKind::kPlaces, 97)[0].key(), orders[0].key());
  const auto strip = order_pictures(*session, PictureKind::kStrip, 96);
  EXPECT_THAT(strip[0].key(), HasSubstr("/B:90.0000:"));
  EXPECT_THAT(refusal<ArgumentError>([&] { order_pictures(*session, PictureKind::kStrip, 12); }),
              HasSubstr("12 pixels, 64 to 2048"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
