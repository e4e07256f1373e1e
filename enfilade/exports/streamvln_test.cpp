#include "enfilade/exports/streamvln.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"
#include "tests/support/made_meshes.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::exports {
namespace {

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
  }
  StreamVlnReport write(const fs::path& folder, const StreamVlnOptions& options = small()) const {
    return write_streamvln(
        episodes, buildings, continuous::SimulatorConfig::room_to_room(),
        [this](const std::string&) { return continuous::Scene::photographed(tracer); }, folder,
        options);
  }
  static StreamVlnOptions small() {
    StreamVlnOptions options;
    options.camera = {64, 48, degrees(60)};
    return options;
  }
};

// Read as the public loader does: annotations, then the folder's pictures in the order of names.
TEST(StreamVln, HasAPictureBeforeEachAction) {
  const World world;
  const tests::TemporaryFolder folder("streamvln");
  const StreamVlnReport report = world.write(folder.path());
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
                testing::Each(testing::AllOf(testing::Ge(1), testing::Le(3))));
    const fs::path rgb = folder.path() / entry["video"].get<std::string>() / "rgb";
    const auto files = std::distance(fs::directory_iterator(rgb), fs::directory_iterator());
    EXPECT_EQ(static_cast<std::size_t>(files), actions.size());
    const image::Image8 first = image::load_picture((rgb / "001.jpg").string());
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
  const StreamVlnReport report = world.write(folder.path());
  EXPECT_EQ(report.episodes, 2U);
  EXPECT_EQ(report.kept, 1U);
  EXPECT_EQ(read_file(walk / "rgb" / "002.jpg"), picture);
}

TEST(StreamVln, RefusesOtherPicturesInAFolder) {
  const World world;
  const tests::TemporaryFolder folder("streamvln");
  world.write(folder.path());
  StreamVlnOptions other = World::small();
  other.camera.width = 80;
  EXPECT_THROW(world.write(folder.path(), other), FileError);
}

TEST(StreamVln, LeavesOutLongWalksAndRefusesHiddenPaths) {
  World world;
  const tests::TemporaryFolder folder("streamvln");
  StreamVlnOptions options = World::small();
  options.most_actions = 5;
  const StreamVlnReport report = world.write(folder.path(), options);
  EXPECT_EQ(report.too_long, 2U);
  EXPECT_EQ(report.episodes, 0U);
  world.episodes.episodes[0].reference_path.reset();
  EXPECT_THROW(world.write(folder.path(), options), ArgumentError);
}

}  // namespace
}  // namespace enfilade::exports
