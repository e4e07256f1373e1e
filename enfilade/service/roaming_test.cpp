// Continuous navigation in a real home, over real sockets: its mesh, its floor, continuous
// episodes.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/agents/continuous_setup.h"
#include "enfilade/continuous/buildings.h"
#include "enfilade/core/gzip.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/mesh/read_mesh.h"
#include "enfilade/service/browsing/site_json.h"
#include "tests/support/served_data.h"
#include "tests/support/small_homes.h"

namespace enfilade::service {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr const char* kScan = "home0001";

/// An episode of the first path's kind, as `enfilade continuous` writes it.
tasks::ContinuousEpisode episode(std::int64_t id, Vec3d start, Vec3d goal) {
  tasks::ContinuousEpisode made;
  made.id = id;
  made.trajectory_id = id + 100;
  made.scene = std::string("mp3d/") + kScan + "/" + kScan + ".glb";
  made.start = start;
  made.rotation = tasks::StartRotation::of(degrees(90));
  made.info = tasks::EpisodeInfo{.geodesic_distance = 2.5, .role = {}};
  made.goals = std::vector<tasks::ContinuousGoal>{{goal, 3.0}};
  made.instruction.text = "Walk to the <b>window</b>, " + std::to_string(id) + ".";
  made.reference_path = std::vector<Vec3d>{start, goal};
  return made;
}

/// A set of small homes, of which the first has a floor, with a server of it.
class RoamingTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new tests::TemporaryFolder("roaming");
    const fs::path data = folder_->path() / "homes";
    tests::write_small_homes(data);
    const auto& setup = agents::continuous_setup("r2r-ce");
    const auto homes = homes::read_home_list(data);
    floor_ = new mesh::FloorPolygons(homes::make_home_floor(
        homes::build_home(homes.front().plan, homes::HomeSurfaces::kPlain), setup.body));
    make_folder(data / setup.navigation_folder());
    continuous::save_navigation_mesh(
        *floor_, data / setup.navigation_folder() / continuous::navigation_mesh_name(kScan));
    make_folder(data / "vlnce");
    for (const char* split : {"val_seen", "test"}) {
      tasks::ContinuousEpisodes episodes{split, "", {}};
      for (std::int64_t id = 1; id <= 3; ++id)
        episodes.episodes.push_back(episode(id, {1, 2, 0}, {3, 4.5, 0}));
      write_file_atomically(data / "vlnce" / (std::string(split) + ".json.gz"), to_json(episodes));
    }
    ServerConfig config;
    config.database = testing::new_database(folder_->path() / "service.sqlite");
    config.port = 0;
    config.threads = 4;
    server_ = new Server(Site::open(data), config);
  }
  static void TearDownTestSuite() {
    delete server_;
    delete floor_;
    delete folder_;
  }

  httplib::Result get(const std::string& target, const httplib::Headers& headers = {}) {
    return client_.Get(target, headers);
  }
  nlohmann::json json(const std::string& target) {
    return nlohmann::json::parse(get(target)->body);
  }
  static const fs::path data() { return folder_->path() / "homes"; }

  static tests::TemporaryFolder* folder_;
  static mesh::FloorPolygons* floor_;
  static Server* server_;
  httplib::Client client_{"127.0.0.1", server_->port()};
};
tests::TemporaryFolder* RoamingTest::folder_ = nullptr;
mesh::FloorPolygons* RoamingTest::floor_ = nullptr;
Server* RoamingTest::server_ = nullptr;

TEST_F(RoamingTest, TheMeshIsTheHomesWithLightInItsCorners) {
  client_.set_read_timeout(120);
  const auto answer = get("/api/v1/scans/home0001/mesh.glb");
  ASSERT_EQ(answer->status, 200);
  EXPECT_EQ(answer->get_header_value("Content-Type"), "model/gltf-binary");
  const mesh::Mesh shown = mesh::parse_mesh(answer->body, "home.glb").mesh;
  const auto built = homes::build_home(homes::read_home_list(data()).front().plan);
  const mesh::Box is = mesh::bounds(shown), should = mesh::bounds(built.home.mesh);
  // Positions are sent to a 65536th of a metre, in single precision.
  EXPECT_NEAR(length(is.low - should.low), 0, 5e-5);
  EXPECT_NEAR(length(is.high - should.high), 0, 5e-5);
  EXPECT_GE(shown.triangles.size(), built.home.mesh.triangles.size());
  ASSERT_EQ(shown.colours.size(), shown.positions.size());
  // Exposed so that the middle of what is seen is mid-grey: much is neither black nor white.
  const auto middling =
      std::ranges::count_if(shown.colours, [](Vec3f c) { return c.y > 0.05F && c.y < 2; });
  EXPECT_GT(static_cast<std::size_t>(middling), shown.colours.size() / 3);
}

TEST_F(RoamingTest, TheMeshIsMadeOnceAndNotSentTwice) {
  client_.set_read_timeout(120);
  const auto first = get("/api/v1/scans/home0001/mesh.glb", {{"Accept-Encoding", "gzip"}});
  const auto again =
      get("/api/v1/scans/home0001/mesh.glb", {{"If-None-Match", first->get_header_value("ETag")}});
  EXPECT_EQ(again->status, 304);
  EXPECT_THAT(again->body, ::testing::IsEmpty());
}

TEST_F(RoamingTest, TheFloorIsTheNavigationMesh) {
  const auto floor = json("/api/v1/scans/home0001/floor");
  EXPECT_EQ(floor.at("walker").at("eye"), 1.25);
  EXPECT_EQ(floor.at("walker").at("forward"), 0.25);
  EXPECT_NEAR(floor.at("walker").at("turn").get<double>(), degrees(15).value, 1e-12);
  EXPECT_EQ(floor.at("body").at("radius"), 0.1);
  const auto& polygons = floor.at("polygons");
  ASSERT_EQ(polygons.size(), floor_->polygons.size());
  for (std::size_t p = 0; p < polygons.size(); ++p) {
    const mesh::FloorPolygon& polygon = floor_->polygons[p];
    ASSERT_EQ(polygons[p].at("beyond").size(), polygon.size());
    EXPECT_EQ(polygons[p].at("area"), polygon.area);
    for (std::size_t k = 0; k < polygon.size(); ++k) {
      const int beyond = polygons[p]["beyond"][k].get<int>();
      EXPECT_EQ(static_cast<std::uint16_t>(beyond), polygon.beyond[k]) << p;  // -1 is kNone
      // A corner is where its lattice says, and as high as the floor is there.
      const auto [x, y, z] = floor_->corners[polygon.corners[k]];
      EXPECT_NEAR(polygons[p]["points"][3 * k].get<double>(), floor_->low.x + floor_->cell * x,
                  2e-5)
          << p;
      EXPECT_NEAR(polygons[p]["points"][3 * k + 1].get<double>(), floor_->low.y + floor_->cell * y,
                  2e-5)
          << p;
    }
    EXPECT_EQ(polygons[p]["points"].size(), 3 * floor_->heights[p].points);
    EXPECT_EQ(polygons[p]["triangles"].size(), 3 * floor_->heights[p].triangles);
  }
}

TEST_F(RoamingTest, SaysWhereOneCanRoamAndWhatIsMissingElsewhere) {
  std::map<std::string, bool> roam;
  const auto scans = json("/api/v1/scans");
  for (const auto& scan : scans.at("scans")) {
    roam[scan.at("scan").get<std::string>()] = scan.at("roam").get<bool>();
  }
  EXPECT_TRUE(roam.at("home0001"));
  EXPECT_FALSE(roam.at("home0002"));
  EXPECT_EQ(json("/api/v1/scans/home0001").at("roam"), true);
  EXPECT_EQ(json("/api/v1/scans/home0002").at("roam"), false);
  const auto floor = get("/api/v1/scans/home0002/floor");
  EXPECT_EQ(floor->status, 404);
  EXPECT_THAT(floor->body, HasSubstr("enfilade continuous DATA"));
  EXPECT_THAT(floor->body, Not(HasSubstr(data().string())));
  for (const char* what : {"floor", "mesh.glb"}) {
    EXPECT_EQ(get(std::string("/api/v1/scans/none/") + what)->status, 404) << what;
  }
}

TEST_F(RoamingTest, EpisodesAreTheFiles) {
  const auto answer = json("/api/v1/continuous/val_seen/episodes?scan=home0001&limit=2");
  EXPECT_EQ(answer.at("matching"), 3);
  EXPECT_EQ(answer.at("goals_hidden"), false);
  ASSERT_EQ(answer.at("episodes").size(), 2U);
  const auto& one = answer["episodes"][0];
  EXPECT_EQ(one.at("id"), "1");
  EXPECT_EQ(one.at("trajectory"), "101");
  EXPECT_EQ(one.at("scan"), kScan);
  EXPECT_EQ(one.at("start"), nlohmann::json({1.0, 2.0, 0.0}));
  EXPECT_NEAR(one.at("heading").get<double>(), degrees(90).value, 1e-9);
  EXPECT_EQ(one.at("path").size(), 2U);
  EXPECT_EQ(one.at("goals")[0].at("position"), nlohmann::json({3.0, 4.5, 0.0}));
  EXPECT_EQ(one.at("distance"), 2.5);
  EXPECT_EQ(json("/api/v1/continuous/val_seen/episodes?id=2")["episodes"][0].at("id"), "2");
  EXPECT_EQ(json("/api/v1/continuous/val_seen/episodes?trajectory=103").at("matching"), 1);
  EXPECT_EQ(json("/api/v1/continuous/val_seen/episodes?scan=home0002").at("matching"), 0);
}

// R2R's test split has no goals in the data set: neither may the continuous one tell them.
TEST_F(RoamingTest, HidesWhatR2rHides) {
  const auto answer = json("/api/v1/continuous/test/episodes");
  EXPECT_EQ(answer.at("goals_hidden"), true);
  ASSERT_EQ(answer.at("episodes").size(), 3U);
  for (const auto& one : answer["episodes"]) {
    EXPECT_TRUE(one.contains("start"));
    for (const char* secret : {"path", "goals", "distance"}) {
      EXPECT_FALSE(one.contains(secret)) << secret;
    }
  }
  EXPECT_THAT(answer.dump(), Not(HasSubstr("4.5")));
}

TEST_F(RoamingTest, RefusesSplitsThatNobodyHas) {
  for (const char* split : {"val_unseen", "..", "%2e%2e%2fsecret", "nothing", "val_seen_gt"}) {
    const auto answer = get(std::string("/api/v1/continuous/") + split + "/episodes");
    EXPECT_EQ(answer->status, 404) << split;
    EXPECT_THAT(answer->body, Not(HasSubstr(data().string()))) << split;
  }
  EXPECT_EQ(get("/api/v1/continuous/val_seen/episodes?limit=0")->status, 400);
}

/// A data set with a mesh of scan "row". \returns its folder
fs::path write_data_with_mesh(const fs::path& folder) {
  testing::write_served_data(folder);
  fs::path data = folder / "data";
  make_folder(data / "meshes");
  mesh::Mesh room;
  room.positions = {{0, 0, 0}, {6, 0, 0}, {6, 4, 0}, {0, 4, 1}};
  room.triangles = {{0, 1, 2}, {0, 2, 3}};
  room.triangle_material = {0, 1};
  room.materials.resize(2);
  mesh::write_glb(room, data / "meshes/row.glb");
  return data;
}

TEST(Roaming, AnUnpackedMeshIsSharedWithinALimit) {
  const tests::TemporaryFolder folder("roaming");
  const auto site = Site::open(write_data_with_mesh(folder.path()));
  const ScanIndex row = *site->graphs().find("row");
  browsing::Roaming roaming(site);
  const auto packed = roaming.mesh(row);
  const auto one = roaming.unpacked(packed), other = roaming.unpacked(packed);
  ASSERT_NE(one, nullptr);
  EXPECT_EQ(one, other);
  EXPECT_EQ(*one, gunzip(*packed.gzip, 1 << 20));
  browsing::Roaming::Packed second = packed;
  second.digest = "another";
  browsing::Roaming narrow(site, packed.bytes + 1);
  auto first = narrow.unpacked(packed);
  EXPECT_EQ(narrow.unpacked(second), nullptr);
  first.reset();  // it was sent
  EXPECT_NE(narrow.unpacked(second), nullptr);
}

TEST(Roaming, AMeshFileIsShownWithItsTextures) {
  const tests::TemporaryFolder folder("roaming");
  const fs::path data = write_data_with_mesh(folder.path());
  ServerConfig config;
  config.database = testing::new_database(folder.path() / "service.sqlite");
  config.port = 0;
  config.threads = 2;
  const Server server(Site::open(data), config);
  httplib::Client client("127.0.0.1", server.port());
  const auto answer = client.Get("/api/v1/scans/row/mesh.glb");
  ASSERT_EQ(answer->status, 200);
  const mesh::Mesh shown = mesh::parse_mesh(answer->body, "row.glb").mesh;
  EXPECT_EQ(shown.triangles.size(), 2U);
  EXPECT_TRUE(shown.colours.empty());
  EXPECT_EQ(mesh::bounds(shown).high, (Vec3f{6, 4, 1}));
  EXPECT_EQ(client.Get("/api/v1/scans/row/floor")->status, 404);
  const auto scan = nlohmann::json::parse(client.Get("/api/v1/scans/row")->body);
  EXPECT_EQ(scan.at("roam"), false);  // there is no floor
}

TEST_F(RoamingTest, EpisodesAreWalkedByRequests) {
  const auto post = [this](const std::string& target, const nlohmann::json& body,
                           const httplib::Headers& headers = {}) {
    return client_.Post(target, headers, body.dump(), "application/json");
  };
  const auto begun =
      post("/api/v1/sessions", {{"task", "r2r-ce"}, {"split", "val_seen"}, {"episode", "1"}});
  ASSERT_EQ(begun->status, 201) << begun->body;
  const auto state = nlohmann::json::parse(begun->body);
  EXPECT_EQ(state.at("observation").at("instruction"), "Walk to the <b>window</b>, 1.");
  EXPECT_FALSE(state.at("observation").contains("places"));
  const std::string path = "/api/v1/sessions/" + state.at("session").dump();
  const httplib::Headers key{{"Enfilade-Session", state.at("key").get<std::string>()}};
  const auto moved = nlohmann::json::parse(
      post(path + "/calls", {{"tool", "move"}, {"argument", "left,left,forward"}}, key)->body);
  EXPECT_TRUE(moved.at("carried_out")) << moved;
  EXPECT_THAT(moved.at("observation").at("told").get<std::string>(), HasSubstr("3 of 3 actions"));
  EXPECT_EQ(client_.Get(path + "/pictures/strip/0", key)->status, 404);
  post(path + "/calls", {{"tool", "stop"}}, key);
  const auto result = nlohmann::json::parse(client_.Get(path + "/result", key)->body);
  EXPECT_EQ(result.at("1").size(), 5U) << "a pose at the start, and one after each action";
  EXPECT_TRUE(result.at("1").back().at("stop"));
  for (const char* split : {"../vlnce/val_seen", "nowhere", "", "val_seen.json"}) {
    const auto refused =
        post("/api/v1/sessions", {{"task", "r2r-ce"}, {"split", split}, {"episode", "1"}});
    EXPECT_EQ(refused->status, 404) << split;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
