// Stores that are replaced while they are served. Visitors get the new pictures, or the old ones.
// Browsers do not keep what is about to change.
#include "enfilade/service/browsing/newest_sources.h"

#include <gmock/gmock.h>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"
#include "enfilade/scan/store.h"
#include "tests/support/panoramas.h"
#include "tests/support/served_data.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::service {
namespace EN_UNIT {

namespace fs = std::filesystem;
using scan::Layer;

/// A store of `count` viewpoints in a row, in place of one that may be there.
void pack_row(const fs::path& folder, std::size_t count, std::uint32_t size) {
  std::vector<scan::Panorama> panoramas;
  for (std::size_t v = 0; v < count; ++v) panoramas.push_back(scan::testing::panorama(size, v));
  scan::pack(
      scan::MemoryPanoramas(scan::testing::row_of_viewpoints("row", count), std::move(panoramas)),
      folder, {});
}

std::uint32_t size_of(const browsing::NewestSource& newest) {
  return newest.source->face_sizes(ViewpointIndex(0))[index(Layer::kColour)];
}

class NewestSourcesTest : public ::testing::Test {
 protected:
  NewestSourcesTest() {
    pack_row(folder_.path(), 3, 16);
    set_ = scan::PanoramaSet::open({.images = {folder_.path()}, .connectivity = {}}, {"row"});
  }
  fs::path store() const { return folder_.path() / "row.enfilade"; }

  const tests::TemporaryFolder folder_{"newest"};
  std::shared_ptr<const scan::PanoramaSet> set_;
};

TEST_F(NewestSourcesTest, AStoreThatWasReplacedIsReadAndTheOldOneStaysOpen) {
  browsing::NewestSources newest(*set_);
  const auto before = newest.get(ScanIndex(0));
  EXPECT_EQ(before.replaced, 0U);
  EXPECT_EQ(size_of(before), 16U);
  pack_row(folder_.path(), 3, 32);
  const auto after = newest.get(ScanIndex(0));
  EXPECT_EQ(after.replaced, 1U);
  EXPECT_EQ(size_of(after), 32U);
  EXPECT_EQ(size_of(before), 16U);
  EXPECT_EQ(scan::read_panorama(*before.source, ViewpointIndex(2)).colour[0].width, 16U);
  EXPECT_EQ(newest.get(ScanIndex(0)).source, after.source) << "opened once";
  // Also where it was replaced between the set's first look and this one's.
  browsing::NewestSources late(*set_);
  EXPECT_EQ(size_of(late.get(ScanIndex(0))), 32U);
}

TEST_F(NewestSourcesTest, WhatIsNoStoreOfTheseViewpointsIsNotTaken) {
  browsing::NewestSources newest(*set_);
  EXPECT_EQ(size_of(newest.get(ScanIndex(0))), 16U);
  pack_row(folder_.path(), 4, 32);
  EXPECT_EQ(size_of(newest.get(ScanIndex(0))), 16U) << "of other viewpoints";
  write_file_atomically(store(), "half a store");
  EXPECT_EQ(size_of(newest.get(ScanIndex(0))), 16U);
  fs::remove(store());
  const auto last = newest.get(ScanIndex(0));
  EXPECT_EQ(size_of(last), 16U);
  EXPECT_EQ(last.replaced, 0U);
  pack_row(folder_.path(), 3, 24);
  EXPECT_EQ(size_of(newest.get(ScanIndex(0))), 24U);
}

/// The same viewpoints with faces twice as large, in place of a store.
void pack_larger(const scan::Store& old, const fs::path& folder) {
  const std::uint32_t size = old.face_sizes(ViewpointIndex(1))[index(Layer::kColour)];
  std::vector<scan::Panorama> larger;
  for (std::size_t v = 0; v < old.size(); ++v) {
    larger.push_back(scan::testing::panorama(2 * size, v));
  }
  scan::pack(scan::MemoryPanoramas(old.connectivity(), std::move(larger)), folder, {});
}

TEST(ReplacedStores, AreSentWithANewNameAndNotKeptMeanwhile) {
  const auto changing = std::make_shared<std::atomic<bool>>(true);
  ServerConfig config;
  config.pictures_change = [changing] { return changing->load(); };
  testing::Served served(config);
  const fs::path folder = served.root() / "data/store";
  const auto old = scan::Store::open(folder / "row.enfilade");
  const auto face = [&served](const std::string& headers_of = "") {
    return served.get(
        "/api/v1/scans/row/viewpoints/v1/faces/0.jpg",
        headers_of.empty() ? httplib::Headers{} : httplib::Headers{{"If-None-Match", headers_of}});
  };
  const auto first = face();
  ASSERT_EQ(first->status, 200);
  EXPECT_EQ(first->get_header_value("Cache-Control"), "no-cache");
  const std::string name = first->get_header_value("ETag");
  EXPECT_EQ(face(name)->status, 304);
  const std::uint32_t size = old->face_sizes(ViewpointIndex(1))[index(Layer::kColour)];
  pack_larger(*old, folder);
  changing->store(false);
  const auto second = face(name);
  ASSERT_EQ(second->status, 200);
  EXPECT_NE(second->get_header_value("ETag"), name);
  EXPECT_EQ(second->get_header_value("Cache-Control"), "public, max-age=86400");
  EXPECT_EQ(image::decode_jpeg(image::bytes_of(second->body), "face").width, 2 * size);
  const auto still = served.get("/api/v1/scans/row/picture.jpg");
  EXPECT_EQ(still->status, 200);
  EXPECT_EQ(still->get_header_value("Cache-Control"), "public, max-age=86400");
}

TEST(ReplacedStores, AreNotKeptIfTheyAreReplacedDuringTheRequest) {
  const auto replace = std::make_shared<std::function<void()>>();
  ServerConfig config;
  config.pictures_change = [replace] {
    if (const auto now = std::exchange(*replace, {})) now();
    return false;
  };
  testing::Served served(config);
  const fs::path folder = served.root() / "data/store";
  const auto old = scan::Store::open(folder / "row.enfilade");
  const std::uint32_t size = old->face_sizes(ViewpointIndex(1))[index(Layer::kColour)];
  *replace = [&] { pack_larger(*old, folder); };
  const auto answer = served.get("/api/v1/scans/row/viewpoints/v1/faces/0.jpg");
  ASSERT_EQ(answer->status, 200);
  EXPECT_EQ(answer->get_header_value("Cache-Control"), "public, max-age=86400");
  EXPECT_EQ(image::decode_jpeg(image::bytes_of(answer->body), "face").width, 2 * size)
      << "the small one would stay for a day";
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
