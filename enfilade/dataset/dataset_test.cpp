#include "enfilade/dataset/dataset.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/scan/store.h"
#include "enfilade/tasks/benchmark.h"
#include "tests/support/graphs.h"
#include "tests/support/made_panoramas.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::dataset {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

void write(const fs::path& file, std::string_view text) {
  make_folder(file.parent_path());
  write_file_atomically(file, text);
}

constexpr const char* kEpisode =
    R"({"episodes": [{"episode_id": 7, "trajectory_id": 15, "scene_id": "mp3d/one/one.glb",
        "start_position": [1, 2, 3], "start_rotation": [0, 0, 0, 1],
        "instruction": {"instruction_text": "Go."}}]})";

// A square building with one path, in Enfilade's layout.
void write_square(const fs::path& folder) {
  write(folder / "connectivity/scans.txt", "square\n");
  write(folder / "connectivity/square_connectivity.json",
        scan::to_json(graph::testing::square("square")));
  write(folder / "r2r/R2R_val_unseen.json",
        R"([{"path_id": 7, "scan": "square", "heading": 0, "path": ["v0", "v1", "v2"],
             "distance": 4, "instructions": ["one", "two", "three", "four"]}])");
  write(folder / "regions/region_to_panorama.json", R"({"square": {"0": ["v0", "v1"]}})");
}

// Means over none would be nothing that a table can show.
TEST(Dataset, ASplitWithoutEpisodesIsRefused) {
  const tests::TemporaryFolder made("dataset_empty");
  write_square(made.path());
  write(made.path() / "r2r/R2R_val_seen.json", "[]");
  const tasks::Benchmark& continuous = tasks::benchmark("r2r-ce");
  const fs::path unpacked = tasks::episode_places(continuous, "val_seen").at(1);
  write(made.path() / unpacked, R"({"episodes": []})");
  const Dataset data(made.path());
  EXPECT_EQ(data.split(tasks::benchmark("r2r"), "val_unseen").size(), 3U);
  const std::string where =
      "R2R_val_seen.json: $: split \"val_seen\": the annotations have no episode";
  EXPECT_THAT([&] { data.split(tasks::benchmark("r2r"), "val_seen"); },
              ThrowsMessage<InvalidInput>(HasSubstr(where)));
  EXPECT_THAT([&] { data.split(continuous, "val_seen"); },
              ThrowsMessage<InvalidInput>(HasSubstr("[no-episodes]")));
}

// Lines that name who sees their objects need no boxes; where there are some, agents get them.
TEST(Dataset, AsksForBoxesOnlyWhereGoalsNeedThem) {
  const tests::TemporaryFolder made("dataset_boxes");
  write_square(made.path());
  const std::string line =
      R"({"instr_id": "square_v0_5_0", "scan": "square", "path": ["v0", "v1"], )"
      R"("pos_vps": ["v1"], "objid": 5, "instruction": "Find the vase.", "instr_encoding": [1]})";
  write(made.path() / "reverie/REVERIE_val_unseen.json", line);
  write(made.path() / "reverie/REVERIE_val_seen.json",
        R"([{"id": "7_5", "path_id": 7, "scan": "square", "heading": 0, "path": ["v0", "v1"],
             "distance": 2, "objId": 5, "instructions": ["Find the vase."]}])");
  using tasks::Task;
  const Dataset data(made.path());
  const auto set = data.episodes(Task::kReverie, "val_unseen");
  EXPECT_EQ(set.objects, nullptr);
  EXPECT_THAT(std::get<tasks::SeenObject>(set.paths.at(0).goal).seen_from,
              ElementsAre(ViewpointIndex(1)));
  EXPECT_THAT([&] { (void)data.episodes(Task::kReverie, "val_seen"); },
              ThrowsMessage<FileError>(HasSubstr("tried: reverie/BBoxes.json")));
  write(made.path() / "reverie/BBoxes.json", R"({"square_v1": {}})");
  EXPECT_NE(data.episodes(Task::kReverie, "val_unseen").objects, nullptr);
}

TEST(Dataset, FindsFilesAsDataRootDoesButTakesWhatIsNamed) {
  const tests::TemporaryFolder made("dataset_files");
  write_square(made.path());
  const Dataset data(made.path());
  EXPECT_EQ(data.connectivity_folder(), made.path() / "connectivity");
  EXPECT_EQ(data.episodes_file(tasks::benchmark(tasks::Task::kR2r), "val_unseen"),
            made.path() / "r2r/R2R_val_unseen.json");
  EXPECT_THAT([&] { (void)data.episodes_file(tasks::benchmark(tasks::Task::kR2r), "val"); },
              ThrowsMessage<FileError>(
                  HasSubstr("tried: r2r/R2R_val.json, r2r/R2R_val.json.gz, tasks/R2R/data/")));
  EXPECT_THAT([&] { Dataset gone(made.path() / "absent"); },
              ThrowsMessage<FileError>(HasSubstr("not a folder")));
  const Dataset named(DatasetConfig{made.path(), "graphs", {"images"}, {}});
  EXPECT_EQ(named.connectivity_folder(), "graphs");
  EXPECT_EQ(named.panorama_places().images, std::vector<fs::path>{"images"});
}

TEST(Dataset, HasGraphsEpisodesAndRegions) {
  const tests::TemporaryFolder made("dataset_parts");
  write_square(made.path());
  const Dataset data(made.path());
  EXPECT_FALSE(data.synthetic());
  EXPECT_EQ(data.graphs()->graph("square").size(), 4U);
  EXPECT_THAT(data.splits(tasks::benchmark(tasks::Task::kR2r)), ElementsAre("val_unseen"));
  EXPECT_TRUE(data.has_split("val_unseen"));
  EXPECT_FALSE(data.has_split("train"));
  EXPECT_FALSE(data.has_split(""));
  const tasks::EpisodeSet episodes = data.episodes("val_unseen");
  EXPECT_EQ(episodes.episodes.size(), 3U);
  EXPECT_EQ(episodes.graphs, data.graphs());
  EXPECT_EQ(data.episodes("val_unseen", tasks::Instructions::kAll).episodes.size(), 4U);
  EXPECT_EQ(data.regions().find("square", "v1"), 0U);
  EXPECT_EQ(data.panoramas()->scans(), data.graphs()->scans());
  EXPECT_EQ(data.panoramas()->find_source(ScanIndex(0)), nullptr);
}

TEST(Dataset, ListsASplitOnceThatHasTwoNames) {
  const tests::TemporaryFolder made("dataset_names");
  write_square(made.path());
  write(made.path() / "cvdn/test_cleaned.json", "[]");
  const Dataset data(made.path());
  const tasks::Benchmark& cvdn = tasks::benchmark("cvdn");
  EXPECT_THAT(data.splits(cvdn), ElementsAre("test"));
  for (const char* name : {"test", "test_cleaned"}) {
    EXPECT_EQ(data.episodes_file(cvdn, name), made.path() / "cvdn/test_cleaned.json");
  }
}

// As people unpack what was packed, and pack what was not.
TEST(Dataset, FilesMayBePackedOrPlain) {
  const tests::TemporaryFolder made("dataset_packed");
  write_square(made.path());
  for (const char* file : {"r2r/R2R_val_unseen.json", "regions/region_to_panorama.json"}) {
    const std::string text = read_file(made.path() / file);
    write(made.path() / (file + std::string(".gz")),
          gzip(text.substr(0, 9), 6) + gzip(text.substr(9), 6));
    fs::remove(made.path() / file);
  }
  const Dataset data(made.path());
  EXPECT_EQ(data.regions().regions(), 1U);
  EXPECT_EQ(data.annotations("val_unseen").paths.size(), 1U);
  EXPECT_EQ(scan::DataRoot(made.path()).annotations("val_unseen"),
            made.path() / "r2r/R2R_val_unseen.json.gz");
  const tasks::Benchmark& vlnce = tasks::benchmark("r2r-ce");
  EXPECT_EQ(data.find_episodes(vlnce, "val_seen"), std::nullopt);
  for (const char* file : {"R2R_VLNCE_v1-3_preprocessed/val_seen/val_seen.json",
                           "vlnce/val_seen.json", "vlnce/val_seen.json.gz"}) {
    write(made.path() / file, kEpisode);
    EXPECT_EQ(data.find_episodes(vlnce, "val_seen"), made.path() / file);
    EXPECT_EQ(data.split(vlnce, "val_seen").size(), 1U);
  }
}

TEST(Dataset, CopiesShareWhatOneOfThemHasOpened) {
  const tests::TemporaryFolder made("dataset_copies");
  write_square(made.path());
  const Dataset one(made.path());
  const Dataset two = one;  // NOLINT(performance-unnecessary-copy-initialization): the point
  EXPECT_EQ(one.graphs(), two.graphs());
  EXPECT_EQ(&one.regions(), &two.regions());
}

TEST(Dataset, OpensAgainWhatCouldNotBeOpened) {
  const tests::TemporaryFolder made("dataset_again");
  const Dataset data(made.path());
  EXPECT_THROW((void)data.graphs(), FileError);
  write_square(made.path());
  EXPECT_EQ(data.graphs()->size(), 1U);
}

TEST(Dataset, SaysWhetherItsBuildingsAreMadeUp) {
  const tests::TemporaryFolder made("dataset_synthetic");
  write(made.path() / "real/README.md", "Scans of our office\n\nNot SYNTHETIC.\n");
  write(made.path() / "readme/README.md", "# SYNTHETIC buildings\n");
  write(made.path() / "homes/homes.json", "{}");
  EXPECT_FALSE(Dataset(made.path() / "real").synthetic());
  EXPECT_TRUE(Dataset(made.path() / "readme").synthetic());
  EXPECT_TRUE(Dataset(made.path() / "homes").synthetic());
}

TEST(Dataset, ToldWhatIsMissingAndHowToGetIt) {
  const tests::TemporaryFolder made("dataset_missing");
  write_square(made.path());
  std::vector<std::string> present, names;
  for (const Part& part : Dataset(made.path()).examine()) {
    names.push_back(part.name);
    if (part.present) {
      present.push_back(part.name + ": " + part.found);
      EXPECT_THAT(part.advice, IsEmpty());
    } else {
      EXPECT_FALSE(part.found.empty() || part.advice.empty()) << part.name;
    }
  }
  EXPECT_THAT(names, ElementsAre("connectivity", "R2R train", "R2R val_seen", "R2R val_unseen",
                                 "R2R test", "regions", "panoramas"));
  EXPECT_THAT(present,
              ElementsAre("connectivity: 1 scans", "R2R val_unseen: 1 paths, 4 instructions",
                          "regions: 1 regions in 1 scans"));
}

TEST(Dataset, MayBeAFolderOfStores) {
  const tests::TemporaryFolder made("dataset_stores");
  for (const char* scan : {"b", "a"}) {
    const scan::MemoryPanoramas panoramas(scan::testing::row_of_viewpoints(scan, 2),
                                          {2, render::testing::made_panorama(8)});
    scan::pack(panoramas, made.path(), {.colour = scan::ColourCoding::kRaw});
  }
  const Dataset all(made.path());
  EXPECT_THAT(all.graphs()->scans(), ElementsAre("a", "b"));
  EXPECT_NE(all.panoramas()->find_source(ScanIndex(1)), nullptr);
  const Dataset one(DatasetConfig{{}, {}, {made.path()}, {"b"}});
  EXPECT_THAT(one.graphs()->scans(), ElementsAre("b"));
  EXPECT_EQ(one.panoramas()->source(ScanIndex(0)).scan(), "b");
}

TEST(Dataset, MayBeSomeScansOnly) {
  const tests::TemporaryFolder made("dataset_scans");
  write_square(made.path());
  // Not in scans.txt: a folder of graphs need not have one then.
  write(made.path() / "connectivity/other_connectivity.json",
        scan::to_json(graph::testing::square("other")));
  const Dataset data(DatasetConfig{made.path(), {}, {}, {"other"}});
  EXPECT_THAT(data.graphs()->scans(), ElementsAre("other"));
  EXPECT_EQ(data.graphs()->graph("other").size(), 4U);
  EXPECT_THAT(
      [&] {
        (void)Dataset(DatasetConfig{made.path(), {}, {}, {"a", "a"}}).graphs();
      },
      ThrowsMessage<ArgumentError>(HasSubstr("\"a\" twice")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::dataset
