#include "enfilade/continuous/habitat/nav_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "enfilade/continuous/habitat/path_finder.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "tests/support/flat_floor.h"

namespace enfilade::continuous::habitat {
namespace EN_UNIT {

using testing::flat_triangles;
using ::testing::HasSubstr;

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

std::string some_file() {
  return to_nav_mesh_file(make_nav_mesh(flat_triangles({{-2, -2, 2, 2}})));
}

template <class T>
T number_at(const std::string& file, std::size_t place) {
  T out;
  std::memcpy(&out, file.data() + place, sizeof out);
  return out;
}
template <class T>
void put_at(std::string& file, std::size_t place, T value) {
  std::memcpy(file.data() + place, &value, sizeof value);
}

std::string code_of(const std::string& file) {
  try {
    parse_nav_mesh(bytes_of(file), "a.navmesh");
  } catch (const InvalidInput& e) {
    EXPECT_THAT(e.what(), HasSubstr("a.navmesh"));
    return e.diagnostics().front().code;
  }
  return "accepted";
}

TEST(HabitatNavMesh, ItsFileIsHabitats) {
  const std::string file = some_file();
  EXPECT_EQ(file.substr(0, 4), "TESM");
  EXPECT_EQ(number_at<std::int32_t>(file, 4), 2);  // version
  EXPECT_EQ(number_at<std::int32_t>(file, 8), 1);  // tiles
  EXPECT_EQ(number_at<float>(file, 12), -2);       // the lowest corner
  EXPECT_EQ(number_at<float>(file, 40), 0.05F);    // cell_size, the first of the settings
  EXPECT_EQ(number_at<float>(file, 48), 1.5F);     // agent_height
  EXPECT_EQ(file.substr(92, 4), std::string("\1\1\1\0", 4));
  EXPECT_EQ(number_at<std::int32_t>(file, 100), static_cast<std::int32_t>(file.size()) - 104);
  EXPECT_EQ(file.substr(104, 4), "VAND");  // the only tile
}

TEST(HabitatNavMesh, IsReadAsItWasWritten) {
  const std::string file = some_file();
  const NavMesh read = parse_nav_mesh(bytes_of(file), "a.navmesh");
  EXPECT_EQ(to_nav_mesh_file(read), file);
  EXPECT_EQ(read.settings, NavMeshSettings{});
  EXPECT_EQ(read.low.x, -2);
}

TEST(HabitatNavMesh, Version1HasNoSettings) {
  std::string file = some_file();
  file.erase(40, 56);
  put_at<std::int32_t>(file, 4, 1);
  const NavMesh read = parse_nav_mesh(bytes_of(file), "a.navmesh");
  EXPECT_EQ(read.settings, NavMeshSettings{});
  EXPECT_EQ(to_nav_mesh_file(read), some_file());
}

TEST(HabitatNavMesh, ThePaddingOfOldSettingsIsNoSwitch) {
  std::string file = some_file();
  file[95] = '\x7f';  // what a program before v0.3.0 left there
  EXPECT_FALSE(parse_nav_mesh(bytes_of(file), "a.navmesh").settings.include_static_objects);
  file[95] = '\1';
  EXPECT_TRUE(parse_nav_mesh(bytes_of(file), "a.navmesh").settings.include_static_objects);
}

TEST(HabitatNavMesh, OtherFilesAreRefused) {
  const std::string file = some_file();
  EXPECT_EQ(code_of(""), "truncated");
  EXPECT_EQ(code_of("enfilade navigation mesh\n"), "not-a-nav-mesh");
  std::string other = file;
  put_at<std::int32_t>(other, 4, 3);
  EXPECT_EQ(code_of(other), "other-version");
  for (std::size_t size = 4; size < file.size(); size += 13) {
    ASSERT_EQ(code_of(file.substr(0, size)), "truncated") << size;
  }
  for (const std::size_t place : {std::size_t{8}, std::size_t{32}, std::size_t{36}}) {
    for (const std::int32_t value : {-1, 0, 1 << 30}) {
      other = file;
      put_at(other, place, value);
      ASSERT_EQ(code_of(other), "damaged") << place << ": " << value;
    }
  }
  for (const std::size_t place : {std::size_t{24}, std::size_t{28}}) {  // the size of tiles
    for (const float value : {0.0F, 1e-9F, 1e9F, std::numeric_limits<float>::quiet_NaN()}) {
      other = file;
      put_at(other, place, value);  // Detour would look through 10^20 tiles
      ASSERT_EQ(code_of(other), "damaged") << place << ": " << value;
    }
  }
}

// Detour trusts the numbers of a tile: those that could lead outside of it are checked.
TEST(HabitatNavMesh, ChangedTilesAreRefusedOrCanBeUsed) {
  const std::string file = to_nav_mesh_file(
      make_nav_mesh(flat_triangles({{-2, -2, 2, 2}, {2, -1, 4, 0}, {-2, 3, 2, 5}})));
  Rng rng(52);
  int refused = 0, used = 0;
  for (int k = 0; k < 3000; ++k) {
    std::string changed = file;
    const std::size_t place = 104 + rng.below(file.size() - 104);
    changed[place] = static_cast<char>(rng.below(256));
    if (code_of(changed) != "accepted") {
      ++refused;
      continue;
    }
    const PathFinder floor(parse_nav_mesh(bytes_of(changed), "a.navmesh"));
    const Vec3f a{-1, 0, -1}, b{3.5F, 0, -0.5F};
    floor.path(a, b);
    floor.step(a, b, Moves::kSlide);
    floor.step(a, b, Moves::kStop);
    floor.random_point();
    floor.vertices();
    ++used;
  }
  EXPECT_GT(refused, 50);
  EXPECT_GT(used, 50);
}

// A gap of eight levels, which is the body's height: Recast 1.6 lets it in, Recast before does not.
TEST(HabitatNavMesh, TheTwoNavigationsDifferWhereABodyFitsExactly) {
  Triangles rooms = flat_triangles({{-2, -2, 2, 2}}, 0);
  const Triangles roof = flat_triangles({{-2, -2, 2, 2}}, 1.9F);
  for (const auto& [a, b, c] : roof.triangles) rooms.triangles.push_back({a + 4, b + 4, c + 4});
  rooms.corners.insert(rooms.corners.end(), roof.corners.begin(), roof.corners.end());
  const PathFinder latest(make_nav_mesh(rooms, {}, Navigation::kLatest));
  const PathFinder before(make_nav_mesh(rooms, {}, Navigation::kV033));
  EXPECT_EQ(latest.islands(), 2U);
  EXPECT_EQ(before.islands(), 1U);
  EXPECT_NEAR(latest.area(), 2 * before.area(), 1e-4);  // sums of float32
}

TEST(HabitatNavMesh, MeshesComeIntoHabitatsFrame) {
  mesh::Mesh mesh;
  mesh.positions = {{1, 2, 3}, {-4, 5, -6}, {0, 75, 0}};
  mesh.triangles = {{0, 1, 2}};
  const Triangles y = triangles_of(mesh, Upright::kY);
  EXPECT_EQ(y.corners[0], (Vec3f{1, 3, -2}));
  EXPECT_EQ(y.corners[1], (Vec3f{-4, -6, -5}));
  EXPECT_EQ(y.triangles[0], (std::array<std::int32_t, 3>{0, 1, 2}));
  // Habitat's quarter turn is off by 2^-23: 9e-6 m at 75 m.
  const Triangles z = triangles_of(mesh, Upright::kZ);
  EXPECT_EQ(z.corners[2], (Vec3f{0, -75 * 0x1p-23F, -75 * (1 + 0x1p-23F)}));
}

TEST(HabitatNavMesh, SettingsAreComparedAsHabitatDoes) {
  NavMeshSettings other;
  other.agent_radius += 0.5e-5F;
  EXPECT_EQ(other, NavMeshSettings{});
  other.agent_radius += 1e-5F;
  EXPECT_NE(other, NavMeshSettings{});
  other = {};
  other.include_static_objects = true;
  EXPECT_NE(other, NavMeshSettings{});
}

TEST(HabitatNavMesh, WhatIsNoFloorIsRefused) {
  EXPECT_THROW(make_nav_mesh({}), InvalidInput);
  Triangles wall{{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}, {{0, 1, 2}}};
  EXPECT_THROW(make_nav_mesh(wall), InvalidInput);
  NavMeshSettings settings;
  settings.cell_size = 0;
  EXPECT_THROW(make_nav_mesh(flat_triangles({{0, 0, 4, 4}}), settings), ArgumentError);
  EXPECT_THROW(make_nav_mesh(flat_triangles({{0, 0, 1e6F, 1e6F}})), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::continuous::habitat
