// What the viewer computes with, over real sockets: distances, legends, plans.
#include <gmock/gmock.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iterator>
#include <map>
#include <string>
#include <vector>

#include "enfilade/core/gzip.h"
#include "enfilade/homes/home_set.h"
#include "enfilade/mesh/house.h"
#include "tests/support/served_data.h"
#include "tests/support/small_homes.h"

namespace enfilade::service {
namespace EN_UNIT {

using ::testing::HasSubstr;
using testing::Served;

std::uint16_t number_at(const std::string& bytes, std::size_t k) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(bytes.at(i)); };
  return static_cast<std::uint16_t>(byte(2 * k) | byte(2 * k + 1) << 8U);
}

TEST(Browsing, DistancesAreTheDepthsReadings) {
  Served served;
  const auto answer = served.get("/api/v1/scans/row/viewpoints/v2/distances");
  ASSERT_EQ(answer->status, 200);
  EXPECT_EQ(answer->get_header_value("Content-Type"), "application/octet-stream");
  constexpr std::size_t kSize = 32;  // of the faces: no more than the most that is sent
  ASSERT_EQ(answer->body.size(), 6 * kSize * kSize * 2);
  const auto store = scan::Store::open(served.root() / "data/store/row.enfilade");
  const auto depth = scan::read_panorama(*store, ViewpointIndex(2)).depth;
  for (std::size_t face = 0; face < 6; ++face) {
    for (std::size_t k = 0; k < kSize * kSize; ++k) {
      const int truth = depth[face].pixels[k];
      const int sent = number_at(answer->body, face * kSize * kSize + k);
      EXPECT_EQ(sent == 0, truth == 0);
      EXPECT_NEAR(sent, truth, 8) << face << ' ' << k;  // 2 mm
    }
  }
}

TEST(Browsing, WhatIsMadeOfPicturesIsNotSentTwice) {
  Served served;
  for (const char* what : {"distances", "legends"}) {
    const std::string target = std::string("/api/v1/scans/row/viewpoints/v2/") + what;
    const auto first = served.get(target);
    EXPECT_THAT(first->get_header_value("Cache-Control"), HasSubstr("public")) << what;
    const auto again = served.get(target, {{"If-None-Match", first->get_header_value("ETag")}});
    EXPECT_EQ(again->status, 304) << what;
    EXPECT_EQ(served.get("/api/v1/scans/row/viewpoints/v9/" + std::string(what))->status, 404);
  }
}

TEST(Browsing, LegendsNameWhatIsInThePictures) {
  Served served;
  const auto legends = served.json("/api/v1/scans/row/viewpoints/v1/legends");
  const auto store = scan::Store::open(served.root() / "data/store/row.enfilade");
  const auto panorama = scan::read_panorama(*store, ViewpointIndex(1));
  std::map<int, int> counted;
  for (const auto& face : panorama.classes) {
    for (const auto id : face.pixels) ++counted[id];
  }
  counted.erase(0);
  std::vector<std::uint16_t> readings;
  for (const auto& face : panorama.depth) {
    std::ranges::copy_if(face.pixels, std::back_inserter(readings), [](auto d) { return d != 0; });
  }
  std::ranges::sort(readings);
  const auto reading = [&](double share) {
    return readings[static_cast<std::size_t>(share * static_cast<double>(readings.size()))] /
           4000.0;
  };
  // To a decimetre, outwards: most of what is seen lies between, and little lies beyond.
  const auto nearest = legends.at("depth").at("nearest").get<double>();
  const auto farthest = legends["depth"].at("farthest").get<double>();
  EXPECT_LE(nearest, reading(0.06));
  EXPECT_GE(nearest, reading(0.04) - 0.1);
  EXPECT_GE(farthest, reading(0.94));
  EXPECT_LE(farthest, std::max(reading(0.96) + 0.1, nearest + 0.5 + 1e-9));
  EXPECT_EQ(legends["depth"].at("colours").size(), 16U);
  const auto& classes = legends.at("classes");
  ASSERT_EQ(classes.size(), counted.size());
  double before = 1;
  for (const auto& one : classes) {
    const double share = counted.at(one.at("id").get<int>()) / (6.0 * 32 * 32);
    EXPECT_NEAR(one.at("share").get<double>(), share, 1e-4);
    EXPECT_LE(one["share"].get<double>(), before);
    before = one["share"].get<double>();
    EXPECT_THAT(one.at("colour").get<std::string>(), ::testing::StartsWith("#"));
    EXPECT_NE(one.at("name"), "");
  }
}

TEST(Browsing, AWrongNameIsQuotedWithTheRightOnes) {
  Served served;
  const auto told = [&served](const std::string& target) {
    const auto answer = served.json("/api/v1/" + target);
    return answer.at("error").at("message").get<std::string>();
  };
  EXPECT_EQ(told("scans/nosuch"), R"(scan: there is no "nosuch"; allowed are row, wing)");
  EXPECT_EQ(told("scans/rov/plan"), R"(scan: there is no "rov"; the nearest is "row")");
  EXPECT_EQ(told("splits/val_seem/episodes"),
            R"(split: there is no "val_seem"; the nearest is "val_seen")");
  EXPECT_EQ(told("splits/val_seen/episodes?task=soon"),
            R"(split: there is no "val_seen"; the data set has none)");
  EXPECT_EQ(told("splits/val_seen/episodes?task=revery"),
            R"(task: there is no "revery"; the nearest is "reverie")");
  EXPECT_EQ(told("scans/row/viewpoints/%22v9/distances"),
            R"(viewpoint "\"v9" of scan row has no pictures)");
}

TEST(Browsing, OfAPlanNothingIsKnownWhereThereAreGraphsAlone) {
  Served served;
  const auto plan = served.json("/api/v1/scans/row/plan");
  EXPECT_EQ(plan.at("rooms").size(), 0U);
  ASSERT_EQ(plan.at("storeys").size(), 1U);
  EXPECT_EQ(plan["storeys"][0].at("walls").size(), 0U);
  EXPECT_EQ(served.get("/api/v1/scans/none/plan")->status, 404);
}

/// A server of a folder.
struct ServedFolder {
  explicit ServedFolder(const std::filesystem::path& data)
      : server(Site::open(data), config(data)), client("127.0.0.1", server.port()) {}
  static ServerConfig config(const std::filesystem::path& data) {
    ServerConfig config;
    config.database = testing::new_database(data.parent_path() / "service.sqlite");
    config.port = 0;
    config.threads = 2;
    return config;
  }
  nlohmann::json json(const std::string& target) {
    return nlohmann::json::parse(client.Get(target)->body);
  }
  Server server;
  httplib::Client client;
};

/// Whether a viewpoint stands within the box around a room's outline.
bool is_in(const nlohmann::json& room, const nlohmann::json& position) {
  std::array<double, 4> box{1e9, 1e9, -1e9, -1e9};
  const auto& outline = room.at("outline");
  for (std::size_t k = 0; k < outline.size(); ++k) {
    const auto value = outline[k].get<double>();
    box[k % 2] = std::min(box[k % 2], value);
    box[2 + k % 2] = std::max(box[2 + k % 2], value);
  }
  const auto x = position[0].get<double>(), y = position[1].get<double>();
  return x >= box[0] && y >= box[1] && x <= box[2] && y <= box[3];
}

TEST(Browsing, AHomesPlanHasItsRoomsAroundTheirViewpoints) {
  const tests::TemporaryFolder folder("plans");
  const auto data = folder.path() / "homes";
  tests::write_small_homes(data, 3);
  ServedFolder served(data);
  for (const homes::HomeEntry& home : homes::read_home_list(data)) {
    const auto scan = served.json("/api/v1/scans/" + home.scan);
    const auto plan = served.json("/api/v1/scans/" + home.scan + "/plan");
    ASSERT_EQ(plan.at("rooms").size(), home.rooms.size());
    ASSERT_EQ(plan.at("storeys").size(), scan.at("storeys").size());
    for (const auto& storey : plan["storeys"]) {
      EXPECT_GT(storey.at("walls").size(), 0U);
      EXPECT_EQ(storey["walls"].size() % 4, 0U);
      EXPECT_GT(storey.at("furniture").size(), 0U);
    }
    for (std::size_t r = 0; r < home.rooms.size(); ++r) {
      const auto& room = plan["rooms"][r];
      EXPECT_EQ(room.at("name"), home.rooms[r].name);
      ASSERT_EQ(room.at("viewpoints").size(), home.rooms[r].viewpoints.size());
      for (const auto v : room["viewpoints"].get<std::vector<std::size_t>>()) {
        EXPECT_TRUE(is_in(room, scan["viewpoints"][v]["position"])) << home.scan << ' ' << r;
      }
    }
  }
}

TEST(Browsing, AScannedBuildingsPlanIsItsHouseFiles) {
  const tests::TemporaryFolder folder("plans");
  const auto data = folder.path() / "data";
  testing::write_served_data(folder.path());
  // A kitchen around all of the row with a turned table, and a bedroom without outline beside it.
  mesh::House house;
  house.name = "row";
  house.levels.push_back({"-", {}, {{-1, -2, 0}, {9, 2, 3}}});
  house.regions.push_back({0, 'k', {}, {{-1, -2, 0}, {6, 2, 2.5}}, 2.5});
  house.regions.push_back({0, 'b', {}, {{6, -2, 0}, {9, 2, 3}}, 0});
  house.surfaces.push_back({0, 'F', {}, {0, 0, 1}, house.regions[0].box});
  for (const Vec3d corner : {Vec3d{-1, -2, 0}, Vec3d{6, -2, 0}, Vec3d{6, 2, 0}}) {
    house.vertices.push_back({0, "-", corner, {0, 0, 1}});
  }
  house.panoramas.push_back({"v1", 0, {1, 0, 1.5}});
  house.categories.push_back({0, "table", 5, "table"});
  house.categories.push_back({1, "wall", 1, "wall"});
  house.objects.push_back({0, 0, {3, 1, 0.4}, {0, 1, 0}, {-1, 0, 0}, {0.8, 0.5, 0.4}});
  house.objects.push_back({0, 1, {3, 2, 1}, {1, 0, 0}, {0, 1, 0}, {3, 0.1, 1}});
  const auto file = data / "v1/scans/row/house_segmentations/row.house";
  std::filesystem::create_directories(file.parent_path());
  write_file_atomically(file.string() + ".gz", gzip(mesh::to_text(house), 6));

  ServedFolder served(data);
  const auto plan = served.json("/api/v1/scans/row/plan");
  ASSERT_EQ(plan.at("rooms").size(), 2U);
  const auto& kitchen = plan["rooms"][0];
  EXPECT_EQ(kitchen.at("name"), "kitchen");
  EXPECT_EQ(kitchen.at("outline"), nlohmann::json({-1.0, -2.0, 6.0, -2.0, 6.0, 2.0}));
  EXPECT_EQ(kitchen.at("height"), 2.5);
  EXPECT_EQ(kitchen.at("viewpoints"), nlohmann::json({1}));
  EXPECT_EQ(plan["rooms"][1].at("name"), "bedroom");
  EXPECT_EQ(plan["rooms"][1].at("outline").size(), 8U);
  EXPECT_EQ(plan["rooms"][1].at("height"), 3.0);  // to the box's top
  // Four sides of the table, 1.6 m along y and 1 m along x; walls of a triangle and of a box.
  const auto table = plan["storeys"][0].at("furniture").get<std::vector<double>>();
  ASSERT_EQ(table.size(), 16U);
  for (std::size_t k = 0; k < table.size(); ++k) {
    // Millimetres are what is written; 1e-6 is the rounding of subtracting two of them.
    EXPECT_NEAR(std::abs(table[k] - (k % 2 == 0 ? 3 : 1)), k % 2 == 0 ? 0.5 : 0.8, 1e-6) << k;
  }
  EXPECT_EQ(plan["storeys"][0].at("walls").size(), (3U + 4U) * 4U);
}

TEST(Browsing, ABrokenListOfHomesIsToldAndNoPlan) {
  const tests::TemporaryFolder folder("plans");
  const auto data = folder.path() / "homes";
  tests::write_small_homes(data, 3);
  ServedFolder served(data);
  write_file_atomically(data / "homes.json", "{");
  const auto answer = served.client.Get("/api/v1/scans/home0001/plan");
  EXPECT_GE(answer->status, 400);
  EXPECT_THAT(answer->body, HasSubstr("\"error\""));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
