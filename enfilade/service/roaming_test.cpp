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
#include "enfilade/continuous/scene.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/homes/built_home.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/homes/lit_home.h"
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

/// RxR's test split, with one start, in a home: its goals are hidden.
void write_hidden_guides(const fs::path& data) {
  const auto graph = nlohmann::json::parse(
      read_file(data / "connectivity" / (std::string(kScan) + "_connectivity.json")));
  const auto start = std::ranges::find_if(
      graph, [](const auto& viewpoint) { return viewpoint.at("included").template get<bool>(); });
  make_folder(data / "rxr");
  write_file_atomically(data / "rxr/rxr_test_guide.jsonl",
                        nlohmann::json{{"instruction_id", 1},
                                       {"scan", kScan},
                                       {"heading", 0.5},
                                       {"path", {start->at("image_id")}},
                                       {"language", "en-IN"},
                                       {"instruction", "Go on"},
                                       {"timed_instruction", nlohmann::json::array()}}
                                .dump() +
                            "\n");
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
      episodes.episodes.resize(1);
      episodes.episodes[0].instruction.language = "hi-IN";
      write_file_atomically(data / "vlnce" / (std::string(split) + "_guide.json.gz"),
                            to_json(episodes));
    }
    write_hidden_guides(data);
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

TEST_F(RoamingTest, EpisodesAreSearchedForWords) {
  const std::string all = "/api/v1/continuous/val_seen/episodes?q=";
  EXPECT_EQ(json(all + "WINDOW").at("matching"), 3);
  const auto second = json(all + "window%3C/b%3E,%202");
  ASSERT_EQ(second.at("matching"), 1);
  EXPECT_EQ(second.at("episodes")[0].at("id"), "2");
  EXPECT_EQ(json(all + "door").at("matching"), 0);
}

TEST_F(RoamingTest, RxrsEpisodesAreTheirOwn) {
  const auto answer = json("/api/v1/continuous/val_seen/episodes?task=rxr-ce");
  EXPECT_EQ(answer.at("task"), "rxr-ce");
  ASSERT_EQ(answer.at("episodes").size(), 1U);
  EXPECT_EQ(answer["episodes"][0].at("language"), "hi-IN");
  EXPECT_TRUE(answer["episodes"][0].contains("path"));
  EXPECT_EQ(get("/api/v1/continuous/val_seen/episodes?task=r2r")->status, 404);
  // RxR's test split hides its goals, and so does what was made from it.
  const auto hidden = json("/api/v1/continuous/test/episodes?task=rxr-ce");
  EXPECT_EQ(hidden.at("goals_hidden"), true);
  EXPECT_THAT(hidden.dump(), Not(HasSubstr("4.5")));
  std::vector<std::string> splits;
  const auto list = json("/api/v1/splits?task=all");
  for (const auto& one : list.at("continuous")) {
    splits.push_back(one.at("title").get<std::string>() + " " + one.at("split").get<std::string>());
  }
  EXPECT_THAT(splits, ::testing::ElementsAre("R2R-CE val_seen", "R2R-CE test", "RxR-CE val_seen",
                                             "RxR-CE test"));
  EXPECT_FALSE(json("/api/v1/splits").contains("continuous"));
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

/// A set of small homes whose first has kept light: green everywhere, so that no other light looks
/// like it.
class KeptLight : public ::testing::Test {
 protected:
  KeptLight() {
    tests::write_small_homes(data_);
    home_ = homes::read_home_list(data_).front();
  }
  void keep_green_light() const {
    const homes::BuiltHome built = homes::build_home(home_.plan);
    mesh::Lights lights;
    lights.sky = {{}, {}, {}};
    lights.ambient = {0, 5, 0};
    const mesh::LitMesh light(built.tracer, lights,
                              {.spacing = 2, .detail = 1, .rays = 1, .bounces = 0});
    make_folder(data_ / "light");
    continuous::Scene::lit(built.tracer, light, {.light_spacing = 0.5})
        ->save(data_ / homes::home_light_file(home_.scan));
  }
  browsing::Roaming::Packed mesh() const {
    const auto site = Site::open(data_);
    return browsing::Roaming(site).mesh(*site->graphs().find(home_.scan));
  }
  /// Share of the mesh's corners that are green.
  static double green(const browsing::Roaming::Packed& packed) {
    const mesh::Mesh shown = mesh::parse_mesh(gunzip(*packed.gzip, packed.bytes), "home.glb").mesh;
    const auto count = std::ranges::count_if(shown.colours, [](Vec3f c) { return c.x < c.y / 2; });
    return static_cast<double>(count) / static_cast<double>(shown.colours.size());
  }
  fs::path kept_mesh() const { return data_ / homes::lit_home_file(home_); }

  const tests::TemporaryFolder folder_{"kept_light"};
  const fs::path data_ = folder_.path() / "homes";
  homes::HomeEntry home_;
};

TEST_F(KeptLight, IsReadAndNothingIsBaked) {
  keep_green_light();
  EXPECT_GT(green(mesh()), 0.8) << "baked light is white nearly everywhere";
}

TEST_F(KeptLight, AMeshIsMadeOnceForAllServers) {
  keep_green_light();
  const auto made = mesh();
  ASSERT_TRUE(fs::exists(kept_mesh()));
  EXPECT_EQ(read_file(kept_mesh()), *made.gzip);
  EXPECT_EQ(mesh().digest, made.digest);
  // What is there is sent as it is.
  write_file_atomically(kept_mesh(), gzip("kept", 6));
  const auto kept = mesh();
  EXPECT_EQ(gunzip(*kept.gzip, kept.bytes), "kept");
  // A damaged file is made again.
  write_file_atomically(kept_mesh(), made.gzip->substr(0, made.gzip->size() / 2));
  EXPECT_EQ(mesh().digest, made.digest);
  EXPECT_EQ(read_file(kept_mesh()), *made.gzip);
}

TEST_F(KeptLight, OfAnotherHomeIsNotTaken) {
  keep_green_light();
  const fs::path light = data_ / homes::home_light_file(home_.scan);
  std::string bytes = read_file(light);
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  write_file_atomically(light, bytes);
  EXPECT_LT(green(mesh()), 0.2) << "it is baked instead";
  homes::HomeEntry other = home_;
  ++other.plan.seed;
  EXPECT_NE(homes::lit_home_file(other), homes::lit_home_file(home_));
}

TEST_F(KeptLight, AFolderThatMayNotBeWrittenIsServedAllTheSame) {
  write_file_atomically(data_ / "light", "a file, where the folder would be");
  EXPECT_GT(mesh().bytes, 100'000U);
  EXPECT_TRUE(fs::is_regular_file(data_ / "light"));
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
