// The real program: `enfilade homes` goes on where it was when it is killed, and writes files of
// Matterport3D's kinds that our readers read.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "enfilade/homes/home_set.h"
#include "enfilade/image/codecs.h"
#include "enfilade/mesh/house.h"
#include "enfilade/mesh/read_mesh.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/scan/matterport_cameras.h"
#include "enfilade/scan/matterport_images.h"
#include "enfilade/scan/store.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "tests/support/emulated.h"
#include "tests/support/folder_content.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::apps {
namespace EN_UNIT {

namespace fs = std::filesystem;
using tests::content_of;
using tests::Process;
using tests::TemporaryFolder;

// Two flats with a few pictures: nearly all of the time goes into their light.
std::vector<std::string> pictures_in(const fs::path& folder) {
  return {EN_PROGRAM, "homes", "-o",      folder.string(), "--preset", "small",
          "--size",   "16",    "--light", "coarse",        "--paths",  "0"};
}
// Three without any, and paths in them.
std::vector<std::string> paths_in(const fs::path& folder) {
  return {EN_PROGRAM, "homes",  "-o", folder.string(), "--preset", "small", "--homes",
          "3",        "--size", "0",  "--paths",       "4"};
}

// That what the list of a folder names is whole, whenever the program was killed.
void expect_whole(const fs::path& folder, bool pictures) {
  if (!fs::exists(folder / "homes.json")) return;
  for (const homes::HomeEntry& home : homes::read_home_list(folder)) {
    const auto graph = scan::load_connectivity(folder / "connectivity", home.scan);
    EXPECT_GT(graph.entries.size(), 0U);
    if (!pictures) continue;
    const auto store = scan::Store::open(scan::store_file(folder / "store", home.scan));
    EXPECT_EQ(store->size(), graph.entries.size());
    EXPECT_TRUE(store->verify().empty()) << home.scan;
  }
}

// What an uninterrupted run makes, and how much work that is.
struct Reference {
  std::map<std::string, std::string> content;
  double work = 0;
};
Reference run_whole(std::vector<std::string> (*arguments)(const fs::path&)) {
  const TemporaryFolder folder("homes");
  Process run(arguments(folder.path()));
  EXPECT_EQ(run.wait(), 0);
  return {content_of(folder.path()), run.work()};
}

void expect_same(const fs::path& folder, const Reference& reference) {
  const auto content = content_of(folder);
  std::vector<std::string> differ;
  for (const auto& [file, bytes] : reference.content) {
    const auto found = content.find(file);
    if (found == content.end() || found->second != bytes) differ.push_back(file);
  }
  for (const auto& [file, bytes] : content) {
    if (!reference.content.contains(file)) differ.push_back("left over: " + file);
  }
  EXPECT_THAT(differ, ::testing::IsEmpty());
}

// The first half of files of the reference where a kill in the middle of writing them leaves it.
void leave_halves(const fs::path& folder, const Reference& reference,
                  const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    const std::string& whole = reference.content.at(file);
    const fs::path half =
        folder / (file + (file.ends_with(".enfilade") ? ".part" : ".part999999999"));
    fs::create_directories(half.parent_path());
    write_file_atomically(half, whole.substr(0, whole.size() / 2 + 7));
  }
}

// Both kinds of kills need what an uninterrupted run makes; so they are one test.
TEST(KilledHomes, GoOnWherePicturesWereAndGetTheSameBytes) {
  if (tests::is_emulated()) GTEST_SKIP() << "in emulation, pictures of homes take an hour";
  const Reference reference = run_whole(pictures_in);
  ASSERT_THAT(reference.content, ::testing::Contains(::testing::Key("store/home0002.enfilade")));
  const TemporaryFolder steps("homes"), times("homes");
  // Each appears when the step before it is done.
  for (const char* file :
       {"README.md", "homes.json", "connectivity/home0001_connectivity.json",
        "store/home0001.enfilade.part", "connectivity/scans.txt",
        "connectivity/home0002_connectivity.json", "store/home0002.enfilade.part"}) {
    const fs::path path = steps.path() / file;
    Process run(pictures_in(steps.path()));
    EXPECT_TRUE(run.killed_when([&] { return fs::exists(path); })) << file;
    expect_whole(steps.path(), true);
  }
  leave_halves(steps.path(), reference,
               {"homes.json", "connectivity/scans.txt", "regions/region_to_panorama.json",
                "connectivity/home0002_connectivity.json", "store/home0002.enfilade"});
  EXPECT_EQ(Process(pictures_in(steps.path())).wait(), 0);
  expect_same(steps.path(), reference);

  int kills = 0;
  for (const double share : {0.21, 0.42}) {
    Process run(pictures_in(times.path()));
    kills += run.killed_when([&] { return run.work() > share * reference.work; });
    expect_whole(times.path(), true);
  }
  EXPECT_EQ(kills, 2);
  EXPECT_EQ(Process(pictures_in(times.path())).wait(), 0);
  expect_same(times.path(), reference);
}

// Kills a run that writes paths when `file` is there. These files follow one another within
// milliseconds; who looks too late, as on a busy machine, takes them away and tries again.
bool killed_at(const fs::path& folder, const char* file) {
  constexpr int kAttempts = 50;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Process run(paths_in(folder));
    if (run.killed_when([&] { return fs::exists(folder / file); })) return true;
    fs::remove_all(folder / "r2r");
    fs::remove_all(folder / "hidden");
  }
  return false;
}

TEST(KilledHomes, GoOnWherePathsWereAndGetTheSameBytes) {
  const Reference reference = run_whole(paths_in);
  ASSERT_THAT(reference.content, ::testing::Contains(::testing::Key("hidden/R2R_test.json")));
  const TemporaryFolder folder("homes");
  for (const char* file : {"connectivity/home0003_connectivity.json", "r2r", "r2r/R2R_train.json",
                           "r2r/R2R_val_unseen.json", "hidden/R2R_test.json"}) {
    EXPECT_TRUE(killed_at(folder.path(), file)) << file;
    expect_whole(folder.path(), false);
  }
  for (const double share : {0.2, 0.35, 0.5, 0.65}) {
    Process run(paths_in(folder.path()));
    run.killed_when([&] { return run.work() > share * reference.work; });
    expect_whole(folder.path(), false);
  }
  leave_halves(folder.path(), reference,
               {"homes.json", "r2r/R2R_train.json", "r2r/R2R_test.json", "hidden/R2R_test.json"});
  EXPECT_EQ(Process(paths_in(folder.path())).wait(), 0);
  expect_same(folder.path(), reference);
}

TEST(HomeOptions, AllTasksCanBeNamedAndEnlargingStandsAlone) {
  const TemporaryFolder folder("homes");
  std::vector<std::string> words = paths_in(folder.path());
  words.insert(words.end(), {"--tasks", "all"});
  ASSERT_EQ(Process(words).wait(), 0);
  for (const std::string& task : homes::home_tasks()) {
    EXPECT_TRUE(fs::exists(folder.path() / task)) << task;
  }
  EXPECT_EQ(Process({EN_PROGRAM, "dataset", folder.path().string(), "--tasks", "all"}).wait(), 0);
  const std::vector<std::string> enlarge{EN_PROGRAM,  "homes", "-o", folder.path().string(),
                                         "--enlarge", "32"};
  EXPECT_EQ(Process(enlarge).wait(), 0) << "homes without pictures stay so";
  EXPECT_FALSE(fs::exists(folder.path() / "store"));
  for (const char* option : {"--preset", "--size"}) {
    std::vector<std::string> both = enlarge;
    both.insert(both.end(), {option, option == std::string("--size") ? "16" : "small"});
    EXPECT_EQ(Process(both).wait(), 2) << option;
  }
}

// Three homes, and what Habitat opens of them.
std::vector<std::string> habitat_in(const fs::path& folder) {
  std::vector<std::string> words = paths_in(folder);
  // By seed 1, Habitat's floor of the third ends at its low doors (docs/homes.md).
  words.insert(words.end(), {"--seed", "2", "--tasks", "r2r", "--parts", "habitat"});
  return words;
}

TEST(HomesForHabitat, AreUprightByPathAndHaveEpisodesThatOurReaderReads) {
  if (tests::is_emulated()) GTEST_SKIP() << "in emulation, floors of homes take an hour";
  const TemporaryFolder folder("homes");
  std::vector<std::string> words = habitat_in(folder.path());
  words.back() += ",mesh,house";
  ASSERT_EQ(Process(words).wait(), 0);
  const fs::path habitat = folder.path() / "habitat";
  const fs::path scene = habitat / "scene_datasets/mp3d/home0001/home0001";
  const fs::path scan = folder.path() / "v1/scans/home0001";
  const fs::path usual = fs::directory_iterator(scan / "matterport_mesh")->path();
  const mesh::Mesh y_up = mesh::read_mesh(usual / (usual.filename().string() + ".glb")).mesh;
  const mesh::Mesh z_up = mesh::read_mesh(scene.string() + ".glb", {.up = mesh::UpAxis::kZ}).mesh;
  EXPECT_EQ(z_up.positions, y_up.positions);
  EXPECT_EQ(z_up.triangles, y_up.triangles);
  EXPECT_EQ(read_file(scene.string() + ".house"),
            read_file(scan / "house_segmentations/home0001.house"));
  const auto episodes = tasks::load_continuous_episodes(
      habitat / "datasets/vln/mp3d/r2r/v1/train/train.json.gz", "train");
  ASSERT_FALSE(episodes.episodes.empty());
  for (const tasks::ContinuousEpisode& episode : episodes.episodes) {
    EXPECT_TRUE(fs::exists(habitat / "scene_datasets" / episode.scene)) << episode.scene;
    EXPECT_GT(episode.info.value().geodesic_distance.value(), 0);
  }
}

TEST(HomesForHabitat, WithoutPathsAreScenesAlone) {
  if (tests::is_emulated()) GTEST_SKIP() << "in emulation, floors of homes take an hour";
  const TemporaryFolder folder("homes");
  EXPECT_EQ(Process({EN_PROGRAM, "homes", "-o", folder.path().string(), "--preset", "small",
                     "--homes", "1", "--size", "0", "--parts", "habitat"})
                .wait(),
            0);
  EXPECT_TRUE(fs::exists(folder.path() / "habitat/scene_datasets/mp3d/home0001/home0001.navmesh"));
  EXPECT_FALSE(fs::exists(folder.path() / "habitat/datasets"));
}

std::string plan_of(const fs::path& folder, const fs::path& file) {
  Process run(
      {EN_PROGRAM, "graph", "draw", "home0001", "--data", folder.string(), "-o", file.string()});
  EXPECT_EQ(run.wait(), 0);
  return read_file(file);
}

TEST(DrawnHomes, LookTheSameByAListOfAnEarlierVersion) {
  const TemporaryFolder folder("homes"), drawn("drawn");
  EXPECT_EQ(Process(paths_in(folder.path())).wait(), 0);
  const std::string plan = plan_of(folder.path(), drawn.path() / "new.svg");
  EXPECT_THAT(plan, ::testing::HasSubstr("furniture"));
  EXPECT_THAT(plan, ::testing::HasSubstr("living room"));
  const fs::path list = folder.path() / "homes.json";
  auto old = nlohmann::ordered_json::parse(read_file(list));
  for (auto& home : old.at("homes")) {
    EXPECT_EQ(home.erase("lines"), 1U);
    for (auto& room : home.at("rooms")) {
      EXPECT_EQ(room.erase("floor"), 1U);
      EXPECT_EQ(room.erase("elevation"), 1U);
    }
  }
  write_file_atomically(list, old.dump());
  EXPECT_EQ(plan_of(folder.path(), drawn.path() / "old.svg"), plan);
}

TEST(HomeParts, AreReadByOurReaders) {
  if (tests::is_emulated()) GTEST_SKIP() << "in emulation, pictures of homes take an hour";
  const TemporaryFolder folder("homes");
  Process run({EN_PROGRAM, "homes", "-o", folder.path().string(), "--preset", "small", "--homes",
               "1", "--size", "8", "--light", "coarse", "--image-width", "20", "--parts", "all",
               "--paths", "0"});
  ASSERT_EQ(run.wait(), 0);
  const homes::HomeEntry home = homes::read_home_list(folder.path()).at(0);
  const fs::path scan = folder.path() / "v1" / "scans" / home.scan;

  const fs::path house_file = scan / "house_segmentations" / (home.scan + ".house");
  const mesh::House house = mesh::parse_house(read_file(house_file), house_file.string());
  ASSERT_EQ(house.regions.size(), home.rooms.size());
  for (std::size_t r = 0; r < home.rooms.size(); ++r) {
    EXPECT_EQ(house.regions[r].label, home.rooms[r].type);
    EXPECT_NEAR(house.regions[r].box.low.x, home.rooms[r].floor.x0, 0.001);
    EXPECT_NEAR(house.regions[r].box.high.y, home.rooms[r].floor.y1, 0.001);
  }
  EXPECT_EQ(house.panoramas.size(), home.viewpoints);

  const auto triangles = [](const fs::path& file) {
    return mesh::read_mesh(file).mesh.triangles.size();
  };
  EXPECT_EQ(triangles(scan / "house_segmentations" / (home.scan + ".ply")), home.triangles);
  const fs::path meshes = fs::directory_iterator(scan / "matterport_mesh")->path();
  const std::string name = (meshes / meshes.filename()).string();
  EXPECT_EQ(triangles(name + ".glb"), home.triangles);
  EXPECT_EQ(triangles(name + ".obj"), home.triangles);

  const auto graph = scan::load_connectivity(folder.path() / "connectivity", home.scan);
  const auto faces =
      scan::open_matterport_images(folder.path(), folder.path() / "connectivity", home.scan);
  ASSERT_EQ(faces->size(), graph.entries.size());
  for (std::size_t v = 0; v < graph.entries.size(); ++v) {
    EXPECT_EQ(faces->poses()[v].viewpoint, graph.entries[v].id);
    EXPECT_EQ(faces->face_sizes(ViewpointIndex(v)), (scan::FaceSizes{8, 8, 8, 8}));
  }

  const fs::path camera_file = scan / "undistorted_camera_parameters" / (home.scan + ".conf");
  const auto cameras =
      scan::parse_undistorted_cameras(read_file(camera_file), camera_file.string());
  EXPECT_EQ(cameras.size(), 18 * home.viewpoints);
  for (const scan::UndistortedCamera& camera : cameras) {
    const std::string jpeg = read_file(scan / "undistorted_color_images" / camera.colour_file);
    const std::string png = read_file(scan / "undistorted_depth_images" / camera.depth_file);
    EXPECT_EQ(image::decode_jpeg(image::bytes_of(jpeg), camera.colour_file).width, 20U);
    EXPECT_EQ(image::decode_png16(image::bytes_of(png), camera.depth_file).height, 16U);
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::apps
