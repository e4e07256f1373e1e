#include "enfilade/continuous/navigation_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <memory>

#include "enfilade/core/file.h"
#include "tests/support/made_meshes.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::continuous {
namespace EN_UNIT {

using mesh::testing::Maker;

mesh::FloorPolygons polygons_of(mesh::Mesh made, const mesh::PolygonOptions& options = {}) {
  const mesh::RayTracer tracer(std::make_shared<const mesh::Mesh>(std::move(made)));
  return make_floor_polygons(tracer, options);
}

// 5 x 4 m, with a pillar of 1 x 1 m in the middle.
mesh::Mesh pillar_room() {
  return Maker().room(0, 0, 5, 4).box({2, 1.5F, 0}, {3, 2.5F, 2.6F}).mesh;
}

// Half a cell, and the error of the rim.
constexpr double kRim = 0.5 * 0.0125 + 0.01;

TEST(NavigationMesh, FindsTheNearestPointOfTheFloor) {
  const NavigationMesh mesh(polygons_of(pillar_room()));
  ASSERT_EQ(mesh.areas(), 1U);
  EXPECT_NEAR(mesh.area_m2(0), 4.8 * 3.8 - 1.2 * 1.2, 22 * 0.02);
  const auto above = mesh.nearest({1, 1, 0.3F});
  ASSERT_TRUE(above);
  EXPECT_NEAR(above->point.x, 1, 1e-6);
  EXPECT_NEAR(above->point.y, 1, 1e-6);
  EXPECT_NEAR(above->point.z, 0, 1e-5);
  const auto in_wall = mesh.nearest({-0.1F, 2, 0});
  ASSERT_TRUE(in_wall);
  EXPECT_NEAR(in_wall->point.x, 0.1, kRim);
  EXPECT_FALSE(mesh.nearest({1, 1, 2.5F}));
  EXPECT_FALSE(mesh.nearest({-3, 2, 0}));
  EXPECT_FALSE(mesh.nearest({std::nanf(""), 2, 0}));
}

TEST(NavigationMesh, WalksSlidesAndStops) {
  const NavigationMesh mesh(polygons_of(pillar_room()));
  Walker walker;
  const FloorPoint from = *mesh.nearest({1, 1, 0});
  const Walked free = mesh.walk(walker, from, {1.25F, 1, 0});
  EXPECT_FALSE(free.at_wall);
  EXPECT_NEAR(free.end.point.x, 1.25, 1e-6);
  // Into the wall y = 0 at 45 degrees: sliding keeps what goes along the wall.
  const FloorPoint near = *mesh.nearest({1, 0.2F, 0});
  const Walked slid = mesh.walk(walker, near, {1.25F, -0.05F, 0});
  EXPECT_TRUE(slid.at_wall);
  EXPECT_NEAR(slid.end.point.x, 1.25, 1e-4);
  EXPECT_NEAR(slid.end.point.y, 0.1, kRim);
  const Walked stopped = mesh.walk(walker, near, {1.25F, -0.05F, 0}, Walls::kStop);
  EXPECT_TRUE(stopped.at_wall);
  EXPECT_NEAR(stopped.end.point.x - 1, 0.2 - stopped.end.point.y, 1e-4);  // still on the line
  EXPECT_NEAR(stopped.end.point.y, 0.1, kRim);
}

TEST(NavigationMesh, ClimbsStairs) {
  const NavigationMesh mesh(polygons_of(mesh::testing::two_storeys().mesh));
  Walker walker;
  FloorPoint at = *mesh.nearest({0.5F, 0.5F, 0});
  float highest = 0;
  for (int step = 0; step < 24; ++step) {
    const float before = at.point.z;
    at = mesh.walk(walker, at, at.point + Vec3f{0.25F, 0, 0}).end;
    EXPECT_LE(std::abs(at.point.z - before), 0.42F);  // two risers of 0.1875 m, and rounding
    highest = std::max(highest, at.point.z);
  }
  EXPECT_NEAR(highest, 3, 0.02);
}

TEST(NavigationMesh, RandomPointsAreUniformAndOnTheFloor) {
  const NavigationMesh mesh(polygons_of(pillar_room()));
  Rng rng(7);
  int left = 0;
  constexpr int kPoints = 20'000;
  for (int i = 0; i < kPoints; ++i) {
    const FloorPoint point = mesh.random_point(rng, 0);
    left += point.point.x < 2 ? 1 : 0;
    const auto found = mesh.nearest(point.point, {0.01F, 0.05F});
    ASSERT_TRUE(found) << point.point.x << ' ' << point.point.y;
    EXPECT_NEAR(found->point.z, point.point.z, 1e-4);
  }
  const double share = 1.9 * 3.8 / (4.8 * 3.8 - 1.2 * 1.2);
  EXPECT_NEAR(left, kPoints * share, 5 * std::sqrt(kPoints * share * (1 - share)) + 0.01 * kPoints);
}

TEST(NavigationMeshFile, ComesBackEqual) {
  const tests::TemporaryFolder folder("navigation");
  const mesh::FloorPolygons floor = polygons_of(mesh::testing::two_storeys().mesh);
  const std::filesystem::path file = folder.path() / "x.navmesh";
  save_navigation_mesh(floor, file);
  const mesh::FloorPolygons back = load_navigation_mesh(file);
  EXPECT_TRUE(back == floor);
  EXPECT_EQ(back.body.radius, floor.body.radius);
  EXPECT_NO_THROW(const NavigationMesh opened(back));
}

std::string code_of(std::string content) {
  try {
    parse_navigation_mesh({reinterpret_cast<const std::uint8_t*>(content.data()), content.size()},
                          "x.navmesh");
  } catch (const InvalidInput& e) {
    return e.diagnostics().front().code;
  }
  return "";
}

TEST(NavigationMeshFile, SaysWhatIsWrongWithIt) {
  const tests::TemporaryFolder folder("navigation");
  const std::filesystem::path file = folder.path() / "x.navmesh";
  save_navigation_mesh(polygons_of(pillar_room()), file);
  const std::string good = read_file(file);
  EXPECT_EQ(code_of(good), "");
  EXPECT_EQ(code_of(""), "not-a-navigation-mesh");
  EXPECT_EQ(code_of("{}"), "not-a-navigation-mesh");
  std::string other = good;
  other[good.find("version ") + 8] = '9';
  EXPECT_EQ(code_of(other), "other-version");
  std::string flipped = good;
  flipped[good.size() / 2] = static_cast<char>(flipped[good.size() / 2] ^ 1);
  EXPECT_EQ(code_of(flipped), "damaged");
  EXPECT_EQ(code_of(good.substr(0, good.size() - 100)), "damaged");
  EXPECT_EQ(code_of(good.substr(0, good.find('\n') + 1)), "truncated");
}

TEST(FloorPolygons, ThatDoNotFitTogetherAreRefused) {
  const mesh::FloorPolygons good = polygons_of(pillar_room());
  EXPECT_THAT(check_polygons(good, "x"), ::testing::IsEmpty());
  const auto code = [&](auto&& change) {
    mesh::FloorPolygons bad = good;
    change(bad);
    const auto faults = check_polygons(bad, "x");
    EXPECT_THROW(NavigationMesh{bad}, InvalidInput);
    return faults.empty() ? std::string() : faults.front().code;
  };
  EXPECT_EQ(code([](auto& f) {
              f.polygons.clear();
              f.heights.clear();
            }),
            "no-floor");
  EXPECT_EQ(code([](auto& f) { f.heights.pop_back(); }), "list-length");
  EXPECT_EQ(code([](auto& f) { f.polygons[0].corners[0] = 5000; }), "bad-index");
  EXPECT_EQ(code([](auto& f) { f.polygons[0].corners.fill(mesh::FloorPolygon::kNone); }),
            "bad-polygon");
  EXPECT_EQ(code([](auto& f) {
              std::swap(f.polygons[1].corners[0], f.polygons[1].corners[1]);
            }).substr(0, 3),
            "bad");
  EXPECT_EQ(code([](auto& f) { f.polygons[0].area = 70'000; }).substr(0, 3), "bad");
  EXPECT_EQ(code([](auto& f) { f.heights[0].first_point = 1'000'000; }), "bad-index");
  EXPECT_EQ(code([](auto& f) { f.points[0].z = std::nanf(""); }), "bad-number");
  EXPECT_EQ(code([](auto& f) { f.cell = 0; }), "bad-number");
}

}  // namespace EN_UNIT
}  // namespace enfilade::continuous
