#include "enfilade/scan/data_root.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::scan {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(DataRoot, KnowsTheLayoutsInTheWild) {
  const tests::TemporaryFolder made("data_root");
  const fs::path& root = made.path();
  fs::create_directories(root / "ours/connectivity");
  fs::create_directories(root / "ours/r2r");
  fs::create_directories(root / "checkout/connectivity");
  fs::create_directories(root / "checkout/tasks/R2R/data");
  fs::create_directories(root / "flat");
  for (const char* file :
       {"ours/connectivity/scans.txt", "ours/r2r/R2R_train.json", "checkout/connectivity/scans.txt",
        "checkout/tasks/R2R/data/R2R_train.json", "flat/scans.txt", "flat/R2R_train.json"}) {
    write_file_atomically(root / file, "x");
  }
  EXPECT_EQ(DataRoot(root / "ours").connectivity(), root / "ours/connectivity");
  EXPECT_EQ(DataRoot(root / "ours").annotations("train"), root / "ours/r2r/R2R_train.json");
  EXPECT_EQ(DataRoot(root / "checkout").annotations("train"),
            root / "checkout/tasks/R2R/data/R2R_train.json");
  EXPECT_EQ(DataRoot(root / "flat").connectivity(), root / "flat");
  EXPECT_THAT([&] { DataRoot(root / "ours").annotations("val"); },
              ThrowsMessage<FileError>(
                  HasSubstr("tried: r2r/R2R_val.json, r2r/R2R_val.json.gz, tasks/R2R/data/")));
  EXPECT_THAT([&] { DataRoot(root / "ours").regions(); },
              ThrowsMessage<FileError>(HasSubstr("holds no region map")));
  EXPECT_THROW(DataRoot(root / "absent"), FileError);

  fs::create_directories(root / "ours/store");
  fs::create_directories(root / "ours/v1/scans");
  const PanoramaPlaces places = DataRoot(root / "ours").panoramas();
  EXPECT_EQ(places.images,
            (std::vector<fs::path>{root / "ours/store", root / "ours/v1/scans", root / "ours"}));
  EXPECT_EQ(places.connectivity, root / "ours/connectivity");
}

}  // namespace EN_UNIT
}  // namespace enfilade::scan
