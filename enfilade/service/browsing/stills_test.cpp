#include "enfilade/service/browsing/pictures.h"

#include <gmock/gmock.h>
#include <map>

#include "enfilade/image/codecs.h"
#include "enfilade/scan/regions.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace EN_UNIT {

constexpr double kRounding = 1e-9;  // of degrees and radians converted once or twice

using ::testing::HasSubstr;
using testing::Served;
using tests::TemporaryFolder;

constexpr std::uint16_t kMetre = 4000;  // quarter millimetres

/// Three viewpoints in a row. Everything is a metre away, but for faces of the second, of which
/// `metres` says how far.
std::shared_ptr<const Site> site_with_view(const std::filesystem::path& folder,
                                           const std::map<CubeFace, int>& metres,
                                           bool with_depth = true) {
  for (const char* name : {"connectivity", "regions"}) make_folder(folder / name);
  const scan::Connectivity row = scan::testing::row_of_viewpoints("row", 3);
  write_file_atomically(folder / "connectivity/scans.txt", "row\n");
  write_file_atomically(folder / "connectivity/row_connectivity.json", scan::to_json(row));
  write_file_atomically(folder / "regions/region_to_panorama.json",
                        scan::to_json({scan::ScanRegions{"row", {{"v0", "v2"}, {"v1"}}}}));
  std::vector<scan::Panorama> panoramas;
  for (std::size_t v = 0; v < 3; ++v) {
    auto& panorama = panoramas.emplace_back(scan::testing::panorama(32, v));
    for (std::size_t face = 0; face < kCubeFaces; ++face) {
      const auto open = metres.find(static_cast<CubeFace>(face));
      const int far = v == 1 && open != metres.end() ? open->second : 1;
      auto& depth = panorama.depth[face];
      std::ranges::fill(depth.pixels, static_cast<std::uint16_t>(far * kMetre));
      if (!with_depth) depth = {};
    }
  }
  scan::pack(scan::MemoryPanoramas(row, std::move(panoramas)), folder / "store", {});
  return Site::open(folder);
}

TEST(Stills, LookWhereItIsMostOpen) {
  const TemporaryFolder folder("stills");
  browsing::Stills stills(site_with_view(folder.path(), {{CubeFace::kRight, 6}}));
  const auto outlook = stills.outlook(ScanIndex(0));
  ASSERT_TRUE(outlook);
  EXPECT_EQ(outlook->viewpoint, ViewpointIndex(1));
  EXPECT_NEAR(to_degrees(outlook->heading), 90,
              kRounding);  // clockwise from the front, which is north
}

TEST(Stills, DoNotLookOutOfAWindow) {
  const TemporaryFolder folder("stills");
  // To the north no viewpoint follows: so the building ends soon.
  browsing::Stills stills(
      site_with_view(folder.path(), {{CubeFace::kRight, 3}, {CubeFace::kFront, 15}}));
  const auto outlook = stills.outlook(ScanIndex(0));
  ASSERT_TRUE(outlook);
  EXPECT_NEAR(to_degrees(outlook->heading), 90, kRounding);
}

TEST(Stills, LookAlongAnEdgeWhereNothingSaysHowFarItIs) {
  const TemporaryFolder folder("stills");
  browsing::Stills stills(site_with_view(folder.path(), {{CubeFace::kRight, 6}}, false));
  const auto outlook = stills.outlook(ScanIndex(0));
  ASSERT_TRUE(outlook);
  EXPECT_EQ(outlook->viewpoint, ViewpointIndex(1));  // the only one with two edges
  const double degrees = to_degrees(outlook->heading);
  EXPECT_TRUE(std::abs(degrees - 90) < 1e-3 || std::abs(degrees - 270) < 1e-3) << degrees;
}

TEST(Stills, ArePicturesOfTheSizeAskedForAndTheSameEachTime) {
  Served served;
  const auto small = served.get("/api/v1/scans/row/picture.jpg");
  ASSERT_EQ(small->status, 200) << small->body;
  EXPECT_EQ(small->get_header_value("Content-Type"), "image/jpeg");
  const auto bytes = std::as_bytes(std::span(small->body));
  const auto picture = image::decode_jpeg(
      {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, "small");
  EXPECT_EQ(picture.width, 640U);
  EXPECT_EQ(picture.height, 400U);
  EXPECT_EQ(served.get("/api/v1/scans/row/picture.jpg?width=640")->body, small->body);
  const auto large = served.get("/api/v1/scans/row/picture.jpg?width=1280");
  EXPECT_EQ(large->status, 200);
  EXPECT_NE(large->body, small->body);
  EXPECT_NE(large->get_header_value("ETag"), small->get_header_value("ETag"));
  const auto again = served.get("/api/v1/scans/row/picture.jpg",
                                {{"If-None-Match", small->get_header_value("ETag")}});
  EXPECT_EQ(again->status, 304);
}

TEST(Stills, HaveTwoSizes) {
  Served served;
  for (const char* width : {"641", "100000", "0", "-640", "x"}) {
    const auto refused = served.get(std::string("/api/v1/scans/row/picture.jpg?width=") + width);
    EXPECT_EQ(refused->status, 400) << width;
    EXPECT_THAT(refused->body, HasSubstr("width: "));
  }
  EXPECT_EQ(served.get("/api/v1/scans/none/picture.jpg")->status, 404);
  EXPECT_EQ(served.get("/api/v1/scans/none/outlook")->status, 404);
}

TEST(Stills, AViewpointsThumbnailLooksWhereItIsMostOpen) {
  const TemporaryFolder folder("stills");
  const auto site = site_with_view(folder.path(), {{CubeFace::kRight, 6}});
  browsing::Stills stills(site);
  const auto file = stills.thumbnail(ScanIndex(0), ViewpointIndex(1));
  ASSERT_TRUE(file);
  EXPECT_EQ(stills.thumbnail(ScanIndex(0), ViewpointIndex(1)), file) << "it is kept";
  const auto bytes = std::as_bytes(std::span(*file));
  const auto picture = image::decode_jpeg(
      {reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, "thumbnail");
  EXPECT_EQ(picture.width, 320U);
  EXPECT_EQ(picture.height, 200U);
  // The middle of the picture is the face to the right, but for what JPEG and filters change.
  const auto faces = scan::read_panorama(site->panoramas().source(ScanIndex(0)), ViewpointIndex(1));
  const auto mean = [](const image::Image8& of, std::size_t channel) {
    double sum = 0;
    for (std::uint32_t y = of.height * 3 / 8; y < of.height * 5 / 8; ++y) {
      for (std::uint32_t x = of.width * 3 / 8; x < of.width * 5 / 8; ++x)
        sum += of.at(x, y)[channel];
    }
    return sum / (of.height * 5 / 8 - of.height * 3 / 8) / (of.width * 5 / 8 - of.width * 3 / 8);
  };
  for (std::size_t channel = 0; channel < 3; ++channel) {
    EXPECT_NEAR(mean(picture, channel),
                mean(faces.colour[static_cast<std::size_t>(CubeFace::kRight)], channel), 12)
        << channel;
  }
}

TEST(Stills, ThumbnailsAreServed) {
  Served served;
  const auto first = served.get("/api/v1/scans/row/viewpoints/v1/picture.jpg");
  ASSERT_EQ(first->status, 200) << first->body;
  EXPECT_EQ(first->get_header_value("Content-Type"), "image/jpeg");
  EXPECT_LT(first->body.size(), 60'000U);
  const auto again = served.get("/api/v1/scans/row/viewpoints/v1/picture.jpg",
                                {{"If-None-Match", first->get_header_value("ETag")}});
  EXPECT_EQ(again->status, 304);
  EXPECT_NE(served.get("/api/v1/scans/row/viewpoints/v2/picture.jpg")->body, first->body);
  EXPECT_EQ(served.get("/api/v1/scans/row/viewpoints/v9/picture.jpg")->status, 404);
  EXPECT_EQ(served.get("/api/v1/scans/none/viewpoints/v1/picture.jpg")->status, 404);
}

TEST(Stills, TellWhereTheyAreTakenFrom) {
  Served served;
  const auto outlook = served.json("/api/v1/scans/row/outlook");
  EXPECT_THAT(outlook.at("viewpoint").get<std::string>(), ::testing::StartsWith("v"));
  EXPECT_GE(outlook.at("heading").get<double>(), 0);
  EXPECT_LT(outlook.at("heading").get<double>(), 2 * kPi);
  EXPECT_NEAR(outlook.at("vfov").get<double>(), kPi / 3, kRounding);
}

TEST(Site, CountsTheRoomsThatHaveViewpoints) {
  const TemporaryFolder folder("rooms");
  EXPECT_EQ(site_with_view(folder.path(), {})->rooms(ScanIndex(0)), 2U);
}

TEST(Site, SaysWhatABuildingHas) {
  Served served;
  const auto row = served.json("/api/v1/scans").at("scans").at(0);
  EXPECT_EQ(row.at("storeys"), 1);
  EXPECT_EQ(row.at("instructions"), 6);  // three paths of two; the test split is elsewhere
  EXPECT_FALSE(row.contains("rooms"));   // no file says which those are
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
