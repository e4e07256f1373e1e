#include "enfilade/exports/habitat_scene.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/mesh/house.h"
#include "enfilade/mesh/read_mesh.h"
#include "tests/support/folder_content.h"
#include "tests/support/furnished_room.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::exports {
namespace EN_UNIT {

namespace fs = std::filesystem;

capture::HouseFiles files_of(const mesh::Mesh& mesh) {
  return make_house_files(mesh, tests::furnished_room_graph(), tests::furnished_room_list());
}

std::map<std::string, std::string> written_to(const fs::path& folder) {
  const mesh::Mesh mesh = tests::furnished_rooms();
  write_habitat_scene(OutputFolder(folder), "rooms", mesh, files_of(mesh));
  return tests::content_of(folder);
}

TEST(HabitatScene, ItsFilesAreWhereHabitatLooks) {
  const tests::TemporaryFolder folder("habitat");
  std::vector<std::string> names;
  for (const auto& [name, content] : written_to(folder.path())) names.push_back(name);
  const std::string scene = "scene_datasets/mp3d/rooms/rooms";
  EXPECT_THAT(names, ::testing::UnorderedElementsAre(scene + ".glb", scene + ".house",
                                                     scene + "_semantic.ply", scene + ".navmesh"));
  EXPECT_EQ(habitat_scene_file("rooms", ".glb"), scene + ".glb");
}

TEST(HabitatScene, TheMeshIsUprightToWhoTakesItToBeZUp) {
  const tests::TemporaryFolder folder("habitat");
  written_to(folder.path());
  const mesh::Mesh read =
      mesh::read_mesh(folder.path() / habitat_scene_file("rooms", ".glb"), {.up = mesh::UpAxis::kZ})
          .mesh;
  const mesh::Box is = bounds(read), should = bounds(tests::furnished_rooms());
  EXPECT_EQ(is.low, should.low);
  EXPECT_EQ(is.high, should.high);
}

TEST(HabitatScene, TheFloorIsThatOfTheRooms) {
  const tests::TemporaryFolder folder("habitat");
  const mesh::Mesh mesh = tests::furnished_rooms();
  const auto floor =
      write_habitat_scene(OutputFolder(folder.path()), "rooms", mesh, files_of(mesh));
  EXPECT_EQ(read_file(folder.path() / habitat_scene_file("rooms", ".navmesh")), floor.file());
  const auto island = floor.island_of(std::array{Vec3f{2.3F, 2.6F, 0}, Vec3f{5, 3.1F, 0}});
  ASSERT_TRUE(island.has_value());
  EXPECT_NEAR(floor.distance({2.3F, 2.6F, 0}, {5, 2.6F, 0}), 2.7, 0.05);  // through the doorway
  EXPECT_FALSE(floor.nearest({1.2F, 1.4F, 0}, *island, {0.01F, 0.3F})) << "below the table";
}

TEST(HabitatScene, LabelsAreObjectsOfTheHouse) {
  const mesh::Mesh mesh = tests::furnished_rooms();
  const capture::HouseFiles files = files_of(mesh);
  const std::string ply = to_semantic_ply(files.labels);
  const std::size_t body = ply.find("end_header\n") + 11;
  EXPECT_THAT(ply.substr(0, body), ::testing::HasSubstr("property list uchar int vertex_indices\n"
                                                        "property int object_id\n"));
  constexpr std::size_t kVertex = 15, kFace = 17;
  const std::size_t vertices = kVertex * mesh.positions.size();
  ASSERT_EQ(ply.size(), body + vertices + kFace * mesh.triangles.size());
  const auto number_at = [&]<class T>(std::size_t at, T value) {
    std::memcpy(&value, ply.data() + at, sizeof value);
    return value;
  };
  EXPECT_EQ(number_at(body, 0.0F), mesh.positions[0].x);
  EXPECT_EQ(number_at(body + 8, 0.0F), mesh.positions[0].z);
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::size_t face = body + vertices + kFace * t;
    EXPECT_EQ(ply[face], 3);
    EXPECT_EQ(number_at(face + 1, std::uint32_t{}), mesh.triangles[t][0]);
    const std::uint32_t object = object_of(mesh, t);
    const std::int32_t wanted = object == mesh::kNoObject ? 0 : static_cast<std::int32_t>(object);
    EXPECT_EQ(number_at(face + 13, std::int32_t{}), wanted);
    EXPECT_LT(wanted, static_cast<std::int32_t>(files.house.objects.size()));
  }
}

TEST(HabitatScene, MoreObjectsThanHabitatsLabelsHoldAreRefused) {
  capture::HouseFiles files = files_of(tests::furnished_rooms());
  files.labels.face_object.front() = 65535;
  EXPECT_NO_THROW(to_semantic_ply(files.labels));
  files.labels.face_object.front() = 65536;
  EXPECT_THROW(to_semantic_ply(files.labels), ArgumentError);
}

TEST(HabitatScene, AFloorIsKeptBesideItsOwnMeshOnly) {
  const tests::TemporaryFolder folder("habitat");
  const auto before = written_to(folder.path());
  const fs::path floor = folder.path() / habitat_scene_file("rooms", ".navmesh");
  const auto made = fs::last_write_time(floor);
  EXPECT_EQ(written_to(folder.path()), before);
  EXPECT_EQ(fs::last_write_time(floor), made);
  // As after a run that was killed, and with a mesh of other options.
  fs::remove(floor);
  EXPECT_EQ(written_to(folder.path()), before);
  write_file_atomically(folder.path() / habitat_scene_file("rooms", ".glb"), "glTF of old");
  write_file_atomically(floor, "no floor");
  EXPECT_EQ(written_to(folder.path()), before);
  write_file_atomically(floor, "no floor");  // beside the right mesh
  EXPECT_THROW(written_to(folder.path()), InvalidInput);
}

TEST(HabitatScene, TheDatasetSaysThatZIsUp) {
  const tests::TemporaryFolder folder("habitat");
  write_habitat_dataset(OutputFolder(folder.path()));
  const auto json = nlohmann::json::parse(
      read_file(folder.path() / "scene_datasets/mp3d/mp3d.scene_dataset_config.json"));
  const nlohmann::json& defaults = json["stages"]["default_attributes"];
  EXPECT_EQ(defaults["up"], (nlohmann::json{0, 0, 1}));
  EXPECT_EQ(defaults["front"], (nlohmann::json{0, 1, 0}));
  EXPECT_EQ(defaults["semantic_up"], (nlohmann::json{0, 1, 0}));  // of a .ply, before its own turn
  EXPECT_EQ(defaults["semantic_front"], (nlohmann::json{0, 0, -1}));
  const std::string scene = "%%CONFIG_NAME_AS_ASSET_FILENAME%%";
  EXPECT_EQ(defaults["nav_asset"], scene + ".navmesh");
  EXPECT_EQ(defaults["semantic_asset"], scene + "_semantic.ply");
  EXPECT_EQ(defaults["semantic_descriptor_filename"], scene + ".house");
  EXPECT_EQ(json["stages"]["paths"][".glb"], nlohmann::json::array({"*/*.glb"}));
}

}  // namespace EN_UNIT
}  // namespace enfilade::exports
