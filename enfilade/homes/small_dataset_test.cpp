#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/graph/check.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/homes/small_building.h"
#include "enfilade/r2r/annotations.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/scan/regions.h"
#include "tests/support/folder_content.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::homes {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using tests::content_of;

class SmallDatasetTest : public ::testing::Test {
 protected:
  const tests::TemporaryFolder made_{"small_dataset"};
  const fs::path folder_ = made_.path() / "new";
};

TEST_F(SmallDatasetTest, ReadsBackWithNothingOdd) {
  write_small_dataset(folder_);
  const scan::DataRoot data(folder_);
  const auto reports = graph::check_folder(data.connectivity());
  ASSERT_EQ(reports.size(), 6U);
  for (const auto& report : reports) EXPECT_TRUE(report.diagnostics.empty()) << report.scan;
  const auto graphs = graph::GraphSet::open(data.connectivity());
  const scan::RegionMap regions = scan::RegionMap::load(data.regions());
  for (const char* split : {"train", "val_seen", "val_unseen", "test"}) {
    SCOPED_TRACE(split);
    const r2r::EpisodeSet episodes =
        r2r::make_episodes(r2r::load_annotations(data.annotations(split), split), graphs);
    EXPECT_GE(episodes.paths.size(), 20U);
    EXPECT_EQ(episodes.episodes.size(), 3 * episodes.paths.size());
    for (const r2r::ReferencePath& path : episodes.paths) {
      if (std::string_view(split) == "test") {
        EXPECT_EQ(path.viewpoints.size(), 1U) << "the goal is hidden";
        continue;
      }
      const graph::NavGraph& graph = graphs->graph(path.scan);
      EXPECT_GE(path.viewpoints.size(), 5U);
      EXPECT_LE(path.viewpoints.size(), 7U);
      const auto region = [&](ViewpointIndex v) { return regions.find(graph.scan(), graph.id(v)); };
      EXPECT_NE(region(path.viewpoints.front()), region(path.viewpoints.back()));
      EXPECT_GE(graph.distance(path.viewpoints.front(), path.viewpoints.back()), 5.0);
    }
  }
}

TEST_F(SmallDatasetTest, KeepsBuildingsOfUnseenSplitsOutOfTraining) {
  write_small_dataset(folder_, 4, 9);
  const scan::DataRoot data(folder_);
  std::map<std::string, std::set<std::string>> scans;
  for (const char* split : {"train", "val_seen", "val_unseen", "test"}) {
    for (const auto& path : r2r::load_annotations(data.annotations(split), split).paths) {
      scans[split].insert(path.scan);
      for (const std::string& text : path.instructions) EXPECT_GT(text.size(), 20U);
    }
  }
  for (const std::string& scan : scans["val_seen"]) EXPECT_TRUE(scans["train"].contains(scan));
  for (const char* split : {"val_unseen", "test"}) {
    EXPECT_FALSE(scans[split].empty());
    for (const std::string& scan : scans[split]) EXPECT_FALSE(scans["train"].contains(scan));
  }
}

TEST_F(SmallDatasetTest, WritesTheSameBytesForTheSameSeed) {
  write_small_dataset(folder_ / "a", 3, 5);
  write_small_dataset(folder_ / "b", 3, 5);
  write_small_dataset(folder_ / "c", 3, 6);
  EXPECT_EQ(content_of(folder_ / "a"), content_of(folder_ / "b"));
  EXPECT_NE(content_of(folder_ / "a").at("r2r/R2R_train.json"),
            content_of(folder_ / "c").at("r2r/R2R_train.json"));
  write_small_dataset(folder_ / "c", 3, 5);  // an earlier one may be written over
  EXPECT_EQ(content_of(folder_ / "a"), content_of(folder_ / "c"));
}

TEST_F(SmallDatasetTest, SaysThatItIsSynthetic) {
  write_small_dataset(folder_, 3);
  EXPECT_THAT(read_file(folder_ / "README.md"), HasSubstr("SYNTHETIC"));
  EXPECT_EQ(read_file(folder_ / "connectivity" / "scans.txt"), "synth_1\nsynth_2\nsynth_3\n");
}

TEST_F(SmallDatasetTest, WritesOverNobodysFiles) {
  fs::create_directories(folder_ / "r2r");
  write_file_atomically(folder_ / "r2r" / "R2R_train.json", "precious");
  EXPECT_THAT([&] { write_small_dataset(folder_); },
              ThrowsMessage<FileError>(HasSubstr("not a synthetic data set")));
  write_file_atomically(folder_ / "README.md", "my data");
  EXPECT_THROW(write_small_dataset(folder_), FileError);
  EXPECT_EQ(read_file(folder_ / "r2r" / "R2R_train.json"), "precious");
}

TEST_F(SmallDatasetTest, RefusesWhatItCannotWrite) {
  EXPECT_THAT([&] { write_small_dataset(folder_, 2); },
              ThrowsMessage<ArgumentError>(HasSubstr("buildings: 2, not in 3 .. 1000")));
  EXPECT_FALSE(fs::exists(folder_));
  write_file_atomically(folder_, "a file");
  EXPECT_THROW(write_small_dataset(folder_), FileError);
}

}  // namespace
}  // namespace enfilade::homes
