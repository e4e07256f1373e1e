#include "enfilade/exports/expert_walks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/image/photo.h"
#include "tests/support/made_meshes.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::exports {
namespace EN_UNIT {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct World {
  std::shared_ptr<const mesh::RayTracer> tracer;
  std::shared_ptr<const continuous::Buildings> buildings;
  tasks::ContinuousEpisodes episodes;

  World() {
    tracer = std::make_shared<const mesh::RayTracer>(std::make_shared<const mesh::Mesh>(
        mesh::testing::Maker().room(0, 0, 6, 4).box({2.5F, 0, 0}, {3, 2.5F, 2.6F}).mesh));
    buildings = std::make_shared<const continuous::Buildings>(std::vector<continuous::Building>{
        {"room",
         std::make_shared<continuous::NavigationMesh>(mesh::make_floor_polygons(*tracer))}});
    for (const std::int64_t id : {7, 12}) {
      tasks::ContinuousEpisode e;
      e.id = e.trajectory_id = id;
      e.scene = "mp3d/room/room.glb";
      e.start = {1, 1, 0};
      e.rotation = tasks::StartRotation::of(degrees(static_cast<double>(id)));
      e.goals = {{{5, 1, 0}, 3}};
      e.instruction.text = "Walk around the wall.";
      e.reference_path = {{1, 1, 0}, {2.7, 3.2, 0}, {5, 1, 0}};
      episodes.episodes.push_back(e);
    }
    episodes.split = "train";
  }
  ExpertWalks walks() const {
    return {episodes, buildings, continuous::SimulatorConfig::room_to_room(),
            [this](const std::string&) {
              return BuildingLook{continuous::Scene::photographed(tracer)};
            }};
  }
  WalkReport write(const fs::path& folder, const WalkPictures& pictures = small()) const {
    return write_streamvln(walks(), folder, pictures);
  }
  static WalkPictures small() {
    WalkPictures options;
    options.camera = {64, 48, degrees(60)};
    return options;
  }
};

// Read as the public loader does: annotations, then the folder's pictures in the order of names.
TEST(StreamVln, HasAPictureBeforeEachAction) {
  const World world;
  const tests::TemporaryFolder folder("streamvln");
  const WalkReport report = world.write(folder.path());
  EXPECT_EQ(report.episodes, 2U);
  EXPECT_EQ(report.kept, 0U);
  const Json all = Json::parse(read_file(folder.path() / "annotations.json"));
  ASSERT_EQ(all.size(), 2U);
  std::size_t pictures = 0;
  for (const Json& entry : all) {
    EXPECT_EQ(entry["instructions"][0], "Walk around the wall.");
    const auto actions = entry["actions"].get<std::vector<int>>();
    ASSERT_GT(actions.size(), 20U);
    EXPECT_EQ(actions[0], -1);
    EXPECT_THAT(std::vector<int>(actions.begin() + 1, actions.end()),
                ::testing::Each(::testing::AllOf(::testing::Ge(1), ::testing::Le(3))));
    const fs::path rgb = folder.path() / entry["video"].get<std::string>() / "rgb";
    const auto files = std::distance(fs::directory_iterator(rgb), fs::directory_iterator());
    EXPECT_EQ(static_cast<std::size_t>(files), actions.size());
    const image::Image8 first = image::load_photo((rgb / "001.jpg").string()).picture;
    EXPECT_EQ(first.width, 64U);
    EXPECT_EQ(first.height, 48U);
    pictures += actions.size();
  }
  EXPECT_EQ(all[0]["id"], 7);
  EXPECT_EQ(all[0]["video"], "images/room_r2r_000007");
  EXPECT_EQ(report.pictures, pictures);
}

TEST(StreamVln, GoesOnWhereItStopped) {
  const World world;
  const tests::TemporaryFolder folder("streamvln");
  world.write(folder.path());
  const fs::path walk = folder.path() / "images" / "room_r2r_000012";
  const std::string picture = read_file(walk / "rgb" / "002.jpg");
  fs::remove_all(walk);
  fs::create_directories(folder.path() / "images" / "room_r2r_000012.part" / "rgb");  // was killed
  const WalkReport report = world.write(folder.path());
  EXPECT_EQ(report.episodes, 2U);
  EXPECT_EQ(report.kept, 1U);
  EXPECT_EQ(read_file(walk / "rgb" / "002.jpg"), picture);
}

TEST(StreamVln, RefusesOtherPicturesInAFolder) {
  const World world;
  const tests::TemporaryFolder folder("streamvln");
  world.write(folder.path());
  WalkPictures other = World::small();
  other.camera.width = 80;
  EXPECT_THROW(world.write(folder.path(), other), FileError);
}

TEST(StreamVln, WantsPhotographsForTheirAppearance) {
  const World world;
  const tests::TemporaryFolder folder("streamvln");
  WalkPictures panoramas = World::small();
  panoramas.appearance = continuous::Appearance::kPanoramas;
  EXPECT_THROW(world.write(folder.path(), panoramas), ArgumentError);
}

// Each form, with the folder that it puts walks into.
constexpr std::array<std::pair<decltype(&write_streamvln), const char*>, 3> kForms{
    {{&write_streamvln, "images"},
     {&write_navila, "R2R/train"},
     {&write_lerobot_parts, "enfilade_export.parts"}}};

TEST(ExpertWalkForms, FollowNoLinkThatSomebodyPutIntoTheFolder) {
  const World world;
  for (const auto& [write, link] : kForms) {
    SCOPED_TRACE(link);
    const tests::TemporaryFolder folder("walks");
    const fs::path out = folder.path() / "out", outside = folder.path() / "outside";
    fs::create_directories((out / link).parent_path());
    fs::create_directory(outside);
    fs::create_directory_symlink(outside, out / link);
    EXPECT_THROW(write(world.walks(), out, World::small(), {}), FileError);
    EXPECT_TRUE(fs::is_empty(outside));
  }
}

TEST(ExpertWalkForms, RefuseAnIdThatLeadsOutOfTheFolder) {
  World world;
  world.episodes.episodes[1].id = std::string("/../../../outside/x");
  for (const auto& [write, link] : kForms) {
    if (write == &write_lerobot_parts) continue;  // its walks have numbers
    SCOPED_TRACE(link);
    const tests::TemporaryFolder folder("walks");
    fs::create_directory(folder.path() / "outside");
    EXPECT_THROW(write(world.walks(), folder.path() / "out", World::small(), {}), ArgumentError);
    EXPECT_TRUE(fs::is_empty(folder.path() / "outside"));
  }
}

TEST(StreamVln, LeavesOutLongWalksAndRefusesHiddenPaths) {
  World world;
  const tests::TemporaryFolder folder("streamvln");
  WalkPictures options = World::small();
  options.most_actions = 5;
  const WalkReport report = world.write(folder.path(), options);
  EXPECT_EQ(report.too_long, 2U);
  EXPECT_EQ(report.episodes, 0U);
  world.episodes.episodes[0].reference_path.reset();
  EXPECT_THROW(world.write(folder.path(), options), ArgumentError);
}

// What the actions of all decisions of a walk are, one after the other, by the sentences.
std::vector<int> actions_of(const Json& entries, const std::string& id) {
  std::vector<int> actions;
  for (const Json& entry : entries) {
    if (!entry["video_id"].get<std::string>().starts_with(id + "-")) continue;
    const auto text = entry["a"].get<std::string>();
    EXPECT_EQ(entry["frames"].size(), actions.size() + 1) << text;
    EXPECT_EQ(entry["frames"].back(), id + "/frame_" + std::to_string(actions.size()) + ".jpg");
    if (text == "I think I should stop because I have finished the instruction.") {
      actions.push_back(0);
      continue;
    }
    const int action = text.find("forward") != std::string::npos ? 1
                       : text.find("left") != std::string::npos  ? 2
                                                                 : 3;
    const int amount = std::stoi(text.substr(text.find_first_of("0123456789")));
    const int one = action == 1 ? 25 : 15;
    EXPECT_EQ(amount % one, 0) << text;
    EXPECT_LE(amount, 3 * one) << text;
    actions.insert(actions.end(), static_cast<std::size_t>(amount / one), action);
  }
  return actions;
}

TEST(NaVila, HasADecisionForUpToThreeEqualActions) {
  const World world;
  const tests::TemporaryFolder folder("navila");
  const WalkReport report = write_navila(world.walks(), folder.path(), World::small());
  EXPECT_EQ(report.episodes, 2U);
  const Json all = Json::parse(read_file(folder.path() / "R2R" / "annotations.json"));
  // The same walks as StreamVLN's, which has an action a picture.
  world.write(folder.path() / "same");
  const Json same = Json::parse(read_file(folder.path() / "same" / "annotations.json"));
  for (const std::size_t k : {0U, 1U}) {
    const std::string id = same[k]["id"].dump();
    auto expected = same[k]["actions"].get<std::vector<int>>();
    expected.erase(expected.begin());
    expected.push_back(0);
    EXPECT_EQ(actions_of(all, id), expected);
  }
  EXPECT_EQ(all[0]["video_id"], "7-0");
  EXPECT_EQ(all[0]["q"], "Walk around the wall.");
  const fs::path frames = folder.path() / "R2R" / "train";
  EXPECT_EQ(read_file(frames / "7" / "frame_0.jpg"),
            read_file(folder.path() / "same" / "images" / "room_r2r_000007" / "rgb" / "001.jpg"));
  EXPECT_EQ(write_navila(world.walks(), folder.path(), World::small()).kept, 2U);
}

// python/tests/test_exports.py makes tables of such parts.
TEST(LeRobot, HasPicturesAndRowsOfEachWalk) {
  const World world;
  const tests::TemporaryFolder folder("lerobot");
  const WalkReport report = write_lerobot_parts(world.walks(), folder.path(), World::small());
  EXPECT_EQ(report.episodes, 2U);
  const fs::path parts = folder.path() / "enfilade_export.parts";
  const Json split = Json::parse(read_file(parts / "episodes.json"));
  EXPECT_EQ(split["split"], "train");
  EXPECT_EQ(split["width"], 64);
  EXPECT_EQ(split["height"], 48);
  ASSERT_EQ(split["episodes"].size(), 2U);
  EXPECT_EQ(split["episodes"][1]["instruction"], "Walk around the wall.");
  const Json rows = Json::parse(read_file(parts / "000001.rows.json"));
  const auto length = split["episodes"][1]["length"].get<std::size_t>();
  ASSERT_EQ(rows["actions"].size(), length);
  ASSERT_EQ(rows["states"].size(), length);
  EXPECT_EQ(split["episodes"][0]["length"].get<std::size_t>() + length, report.pictures);
  EXPECT_EQ(rows["actions"].back(), 0);
  EXPECT_EQ(rows["states"][0].size(), 4U);
  EXPECT_FLOAT_EQ(rows["states"][0][0].get<float>(), 1);
  EXPECT_FLOAT_EQ(rows["states"][0][3].get<float>(), static_cast<float>(degrees(12).value));
  const Json mean = rows["pixels"]["mean"];
  ASSERT_EQ(mean.size(), 3U);
  EXPECT_TRUE(mean[2].get<double>() > 0 && mean[2].get<double>() < 1) << mean;
  double least = rows["pixels"]["min"][1].get<double>();
  for (const char* next : {"q01", "q10", "q50", "q90", "q99", "max"}) {
    const auto value = rows["pixels"][next][1].get<double>();
    EXPECT_GE(value, least) << next;
    least = value;
  }
  // The same pictures as StreamVLN's.
  world.write(folder.path() / "same");
  EXPECT_EQ(read_file(parts / "000001" / "frame_000001.jpg"),
            read_file(folder.path() / "same" / "images" / "room_r2r_000012" / "rgb" / "002.jpg"));
}

TEST(LeRobot, GoesOnWhereItStopped) {
  const World world;
  const tests::TemporaryFolder folder("lerobot");
  const auto write = [&] {
    return write_lerobot_parts(world.walks(), folder.path(), World::small()).kept;
  };
  EXPECT_EQ(write(), 0U);
  const fs::path parts = folder.path() / "enfilade_export.parts";
  fs::remove_all(parts / "000001");
  EXPECT_EQ(write(), 1U);
  // Python has made a table of the first.
  fs::remove_all(parts / "000000");
  const fs::path tables = folder.path() / "data" / "chunk-000";
  make_folder(tables);
  write_file_atomically(tables / "episode_000000.parquet", "");
  write_file_atomically(parts / "000000.json", "{}");
  write_file_atomically(
      parts / "tables.json",
      R"({"version":"2.1","videos":false,"tables":[)"
      R"({"files":["data/chunk-000/episode_000000.parquet"],"first":0,"count":1},)"
      R"({"files":["data/chunk-000/episode_000001.parquet"],"first":1,"count":1}]})");
  EXPECT_EQ(write(), 2U);
  EXPECT_FALSE(file_exists(parts / "000000"));
  fs::remove(tables / "episode_000000.parquet");
  EXPECT_EQ(write(), 1U);
}

TEST(LeRobot, ATableOfManyEpisodesIsThereWithItsVideo) {
  const World world;
  const tests::TemporaryFolder folder("lerobot");
  const auto write = [&] {
    return write_lerobot_parts(world.walks(), folder.path(), World::small()).kept;
  };
  write();
  const fs::path parts = folder.path() / "enfilade_export.parts";
  make_folder(folder.path() / "data");
  write_file_atomically(folder.path() / "data" / "file-000.parquet", "");
  write_file_atomically(folder.path() / "data" / "file-000.mp4", "");
  write_file_atomically(parts / "tables.json",
                        R"({"tables":[{"files":["data/file-000.parquet","data/file-000.mp4"],)"
                        R"("first":0,"count":2}]})");
  for (const char* number : {"000000", "000001"}) {
    fs::remove_all(parts / number);
    write_file_atomically(parts / (std::string(number) + ".json"), "{}");
  }
  EXPECT_EQ(write(), 2U);
  fs::remove(folder.path() / "data" / "file-000.mp4");
  EXPECT_EQ(write(), 0U) << "without the video all its pictures are rendered anew";
  for (const char* wrong : {"[]", "{", R"({"tables":[{"first":0}]})"}) {
    write_file_atomically(parts / "tables.json", wrong);
    EXPECT_THROW(write(), InvalidInput) << wrong;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::exports
