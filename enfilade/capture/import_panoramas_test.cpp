#include "enfilade/capture/import_panoramas.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"
#include "enfilade/scan/panorama_set.h"
#include "enfilade/scan/store.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::capture {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// A folder with two equirectangular pictures of 64 x 32 pixels.
class ImportPanoramas : public ::testing::Test {
 protected:
  ImportPanoramas() {
    for (const char* name : {"hall.jpg", "attic.jpg"}) {
      const auto jpeg = image::encode_jpeg(image::Image8(64, 32, 3), 90);
      write_file_atomically(folder_.path() / name, std::string(jpeg.begin(), jpeg.end()));
    }
  }
  std::string file(const char* name) const { return (folder_.path() / name).string(); }
  ImportReport import(const std::string& scan, const std::vector<PanoramaFiles>& panoramas,
                      const ImportOptions& options = {}) const {
    return import_panoramas(folder_.path(), scan, panoramas, options);
  }

  tests::TemporaryFolder folder_{"import_panoramas"};
};

// As HM3D names its buildings, and with the six digits that its viewpoints get.
TEST_F(ImportPanoramas, GoWithTheirIdsThroughGraphPicturesAndStore) {
  const std::string scan = "00000-kfPV7w3FaU5";
  const ImportReport report =
      import(scan, {{"000000", {file("hall.jpg")}}, {"000001", {file("attic.jpg")}}});
  EXPECT_EQ(report.viewpoints, 2U);
  EXPECT_EQ(report.added, 2U);
  EXPECT_EQ(report.edges, 1U);

  const fs::path connectivity = folder_.path() / "connectivity";
  EXPECT_THAT(scan::load_scan_list(connectivity), ElementsAre(scan));
  EXPECT_EQ(scan::load_connectivity(connectivity, scan).entries[1].id, "000001");

  const fs::path stores = folder_.path() / "store";
  const auto loose = scan::open_panoramas({{folder_.path()}, connectivity}, scan);
  EXPECT_EQ(loose->face_sizes(loose->at("000001"))[index(scan::Layer::kColour)], 16U);
  const scan::PackReport packed = scan::pack(*loose, stores, {});
  EXPECT_EQ(packed.file.filename(), scan + ".enfilade");
  const auto store = scan::open_panoramas({{stores}, {}}, scan);
  EXPECT_EQ(store->at("000001").at(), 1U);
  EXPECT_EQ(store->connectivity().scan, scan);
}

TEST_F(ImportPanoramas, AddToAScanAndKeepItsEdges) {
  import("home", {{"hall", {file("hall.jpg")}}});
  ImportOptions options;
  options.edges = ImportEdges::kNone;
  options.pairs = {{"attic", "hall"}};
  const ImportReport report = import("home", {{"attic", {file("attic.jpg")}}}, options);
  EXPECT_EQ(report.added, 1U);
  EXPECT_EQ(report.edges, 1U);
  EXPECT_DOUBLE_EQ(report.panoramas[0].position.x, kImportSpacing);
  EXPECT_THAT(
      [&] {
        import("home", {{"hall", {file("hall.jpg")}}});
      },
      ThrowsMessage<ArgumentError>(HasSubstr("is in scan home already")));
  options.force = true;
  EXPECT_EQ(import("home", {{"hall", {file("hall.jpg")}}}, options).added, 0U);
}

TEST_F(ImportPanoramas, LeaveTheScanAsItWasIfAPictureIsBroken) {
  write_file_atomically(folder_.path() / "broken.jpg", "GIF89a");
  EXPECT_THROW(import("home", {{"hall", {file("hall.jpg")}}, {"x", {file("broken.jpg")}}}),
               InvalidInput);
  EXPECT_FALSE(fs::exists(folder_.path() / "home"));
  EXPECT_FALSE(fs::exists(folder_.path() / "connectivity"));
}

TEST_F(ImportPanoramas, WriteNothingIfTheListOfScansIsBroken) {
  make_folder(folder_.path() / "connectivity");
  write_file_atomically(folder_.path() / "connectivity" / "scans.txt", "a a");
  EXPECT_THROW(import("home", {{"hall", {file("hall.jpg")}}}), InvalidInput);
  EXPECT_FALSE(fs::exists(folder_.path() / "home"));
  EXPECT_FALSE(fs::exists(scan::connectivity_file(folder_.path() / "connectivity", "home")));
}

TEST_F(ImportPanoramas, RefuseIdsAndCountsThatCannotBe) {
  EXPECT_THROW(import("../home", {{"hall", {file("hall.jpg")}}}), LookupError);
  EXPECT_THROW(import("home", {{"my hall", {file("hall.jpg")}}}), ArgumentError);
  EXPECT_THROW(import("home", {{"hall", {}}}), ArgumentError);
  EXPECT_THROW(import("home", {{"a", {file("hall.jpg")}}, {"a", {file("attic.jpg")}}}),
               ArgumentError);
  ImportOptions options;
  options.face_size = kLargestImportedFace + 1;
  EXPECT_THROW(import("home", {{"hall", {file("hall.jpg")}}}, options), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::capture
