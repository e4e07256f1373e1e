#include "enfilade/homes/looks/style.h"

#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <tuple>

namespace enfilade::homes::looks {
namespace EN_UNIT {

Plan plan_of(const std::string& types, std::uint64_t seed) {
  Plan plan;
  plan.seed = seed;
  for (const char type : types) plan.rooms.push_back({type, "room", 0, {0, 0, 4, 4}, 2.6});
  return plan;
}

TEST(Styles, NoTwoRoomsOfATypeShareWallAndAccent) {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    mesh::Mesh mesh;
    mesh::MeshBuilder builder(mesh);
    const std::string types = "hlkd" + std::string(24, 'b') + std::string(18, 'a') + "oom";
    const auto styles = make_styles(plan_of(types, seed), builder);
    ASSERT_EQ(styles.size(), types.size());
    std::set<std::tuple<char, std::string, std::string>> seen;
    for (std::size_t i = 0; i < styles.size(); ++i) {
      const RoomStyle& s = styles[i];
      EXPECT_TRUE(seen.insert({types[i], s.wall.colour, s.accent.colour}).second) << i;
      EXPECT_EQ(s.rug.colour, s.accent.colour);
      EXPECT_NE(s.fabric.id.value, s.fabric2.id.value);
      EXPECT_EQ(s.wood.id.value, styles[0].wood.id.value);
      EXPECT_EQ(s.metal.id.value, styles[0].metal.id.value);
    }
  }
}

TEST(Styles, AreSmallSoundAndTheSameForASeed) {
  const auto build = [](std::uint64_t seed) {
    mesh::Mesh mesh;
    mesh::MeshBuilder builder(mesh);
    make_styles(plan_of("ehlkdbbaat", seed), builder);
    return mesh;
  };
  const mesh::Mesh a = build(3), b = build(3), c = build(4);
  ASSERT_EQ(a.materials.size(), b.materials.size());
  std::size_t textured = 0, bytes = 0;
  bool same = a.materials.size() == c.materials.size();
  for (std::size_t i = 0; i < a.materials.size(); ++i) {
    const mesh::Material& m = a.materials[i];
    EXPECT_EQ(m.texture, b.materials[i].texture);
    EXPECT_EQ(m.colour, b.materials[i].colour);
    same = same && m.texture == c.materials[i].texture && m.name == c.materials[i].name;
    textured += m.texture.pixels.empty() ? 0 : 1;
    bytes += m.texture.pixels.size();
    for (const float part : {m.colour.x, m.colour.y, m.colour.z}) {
      EXPECT_GE(part, 0);
      EXPECT_LE(part, 1);
    }
  }
  EXPECT_FALSE(same);
  EXPECT_LE(textured, 60U);
  EXPECT_LE(bytes, std::size_t{8} << 20);
}

/// Seams would show as a jump between the last and the first column (row).
TEST(Styles, TexturesOfWallsAndFloorsAreSeamless) {
  mesh::Mesh mesh;
  mesh::MeshBuilder builder(mesh);
  const auto styles = make_styles(plan_of("ehlkdbbaato", 9), builder);
  std::set<std::uint32_t> surfaces;
  for (const RoomStyle& s : styles) {
    for (const NamedMaterial& m : {s.wall, s.floor, s.fabric}) surfaces.insert(m.id.value);
  }
  for (const std::uint32_t id : surfaces) {
    const image::Image8& t = mesh.materials[id].texture;
    SCOPED_TRACE(mesh.materials[id].name);
    const auto step = [&](bool across, std::size_t a, std::size_t b) {
      double sum = 0;
      for (std::size_t i = 0; i < t.width; ++i) {
        const std::uint8_t* p = across ? t.at(a, i) : t.at(i, a);
        const std::uint8_t* q = across ? t.at(b, i) : t.at(i, b);
        sum += std::abs(p[0] - q[0]) + std::abs(p[1] - q[1]) + std::abs(p[2] - q[2]);
      }
      return sum / t.width;
    };
    for (const bool across : {true, false}) {
      double largest = 0;
      for (std::size_t i = 0; i + 1 < t.width; ++i) {
        largest = std::max(largest, step(across, i, i + 1));
      }
      // A joint between boards or tiles may lie at the edge: not more than the largest within.
      EXPECT_LE(step(across, t.width - 1, 0), 1.3 * largest + 3);
    }
  }
}

TEST(PaintPicture, DiffersFromDrawToDraw) {
  Rng rng(1);
  std::set<std::string> pictures;
  for (int i = 0; i < 12; ++i) {
    const image::Image8 picture = paint_picture(rng, 48, 36);
    EXPECT_EQ(picture.channels, 3U);
    pictures.emplace(picture.pixels.begin(), picture.pixels.end());
  }
  EXPECT_EQ(pictures.size(), 12U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::homes::looks
