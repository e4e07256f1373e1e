#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <tuple>
#include <vector>

#include "enfilade/core/gzip.h"
#include "enfilade/mesh/mesh_builder.h"
#include "enfilade/mesh/mpcat40.h"
#include "enfilade/mesh/read_mesh.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::mesh {
namespace EN_UNIT {

Material textured(std::uint32_t channels) {
  Material material;
  material.name = channels == 4 ? "leaves" : "tiles";
  material.colour = {.9F, .5F, .25F};
  material.texture = image::Image8(8, 8, channels);
  for (std::size_t i = 0; i < material.texture.pixels.size(); ++i) {
    const std::size_t x = i / channels % 8, y = i / channels / 8;
    material.texture.pixels[i] = static_cast<std::uint8_t>(40 + 10 * x + 12 * y);
  }
  if (channels == 4) material.cutout = .4F;
  return material;
}

/// A table with a lamp and a plant on it, and a ball that belongs to no object.
Mesh still_life() {
  Mesh mesh;
  MeshBuilder b(mesh);
  const MaterialId tiles = b.add_material(textured(3), .5), leaves = b.add_material(textured(4), 0);
  Material light;
  light.name = "bulb";
  light.emission = {3, 1.5F, .75F};
  const MaterialId bulb = b.add_material(light);
  b.sphere(tiles, {3, 2, 1}, .3);
  b.begin_object("table", Mpcat40::kTable, 0, {{1, 2, 0}, .4});
  b.box(tiles, {-.5, -.3, 0}, {.5, .3, .8});
  b.begin_object("lamp", Mpcat40::kLighting, 0, {{1, 2, .8}, 0});
  b.box(tiles, {-.1, -.1, 0}, {.1, .1, .05});
  b.sphere(bulb, {0, 0, .3}, .1);
  b.begin_object("plant", Mpcat40::kPlant, 1);
  b.quad(leaves, {2, 2, 0}, {2.5, 2, 0}, {2.5, 2, 1}, {2, 2, 1});
  return mesh;
}

using Corners = std::array<std::array<float, 8>, 3>;
/// What of a triangle does not depend on how vertices are numbered; the object by name.
std::vector<std::tuple<std::string, std::uint32_t, Corners>> triangles(const Mesh& mesh) {
  std::vector<std::tuple<std::string, std::uint32_t, Corners>> all;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::uint32_t object = object_of(mesh, t);
    Corners corners;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f p = mesh.positions[mesh.triangles[t][k]], n = mesh.normals[t][k];
      const bool has_texture = !mesh.materials[mesh.triangle_material[t]].texture.pixels.empty();
      const TexturePoint uv = has_texture ? mesh.texture_points[t][k] : TexturePoint{};
      const auto rounded = [](float x) { return std::round(x * 1e4F) / 1e4F + 0.0F; };
      corners[k] = {p.x, p.y, p.z, uv.u, uv.v, rounded(n.x), rounded(n.y), rounded(n.z)};
    }
    all.emplace_back(object == kNoObject ? "unlabelled" : mesh.objects[object].name,
                     mesh.triangle_material[t], corners);
  }
  std::ranges::sort(all);
  return all;
}

TEST(WriteGlb, PackedForViewersHasRoundedNumbers) {
  Mesh made = still_life();
  made.colours.assign(made.positions.size(), {1 / 3.0F, 0.5F, 2 / 3.0F});
  made.positions.front().x = 1 / 3.0F;
  const std::string plain = to_glb(made), packed = to_packed_glb(made);
  EXPECT_LT(packed.size(), plain.size());
  const Mesh read = parse_mesh(gunzip(packed, 2 * plain.size()), "still.glb").mesh;
  ASSERT_EQ(read.triangles.size(), made.triangles.size());
  const Box is = bounds(read), should = bounds(made);
  EXPECT_NEAR(length(is.low - should.low), 0, 2.0 / 65536) << "half a step along each axis";
  EXPECT_NEAR(length(is.high - should.high), 0, 2.0 / 65536);
  for (const Vec3f c : read.colours) {
    EXPECT_EQ(c, (Vec3f{171 / 512.0F, 0.5F, 341 / 512.0F})) << "thirds, to 1/512";
  }
}

TEST(WriteGlb, IsReadBackWithTheSameTrianglesMaterialsAndTextures) {
  const tests::TemporaryFolder folder("glb");
  const Mesh made = still_life();
  write_glb(made, folder.path() / "still.glb");
  const ReadResult read = read_mesh(folder.path() / "still.glb");
  EXPECT_TRUE(read.warnings.empty());
  EXPECT_EQ(triangles(read.mesh), triangles(made));
  ASSERT_EQ(read.mesh.materials.size(), made.materials.size());
  for (std::size_t i = 0; i < made.materials.size(); ++i) {
    const Material &a = made.materials[i], &b = read.mesh.materials[i];
    EXPECT_EQ(b.name, a.name);
    EXPECT_EQ(b.colour, a.colour);
    EXPECT_EQ(b.emission, a.emission);
    EXPECT_EQ(b.cutout, a.cutout);
    ASSERT_EQ(b.texture.pixels.size(), a.texture.pixels.size());
    const int most = a.texture.channels == 4 ? 0 : 12;  // PNG loses nothing, JPEG a little
    for (std::size_t p = 0; p < a.texture.pixels.size(); ++p) {
      EXPECT_LE(std::abs(a.texture.pixels[p] - b.texture.pixels[p]), most) << a.name;
    }
  }
}

TEST(WriteGlb, ZUpHasTheSameNumbersTurned) {
  const Mesh made = still_life();
  const std::string z_up = to_glb(made, UpAxis::kZ);
  EXPECT_EQ(z_up.size() % 4, 0U);
  const ReadResult upright = parse_mesh(z_up, "still.glb", {.up = UpAxis::kZ});
  EXPECT_TRUE(upright.warnings.empty());
  EXPECT_EQ(triangles(upright.mesh), triangles(made));
  // Vertices are those of the y-up file, in its order, to the bit.
  const Mesh usual = parse_mesh(to_glb(made), "still.glb").mesh;
  EXPECT_EQ(upright.mesh.positions, usual.positions);
  EXPECT_EQ(upright.mesh.triangles, usual.triangles);
  // By glTF's own axes it lies on its back.
  const Mesh lying = parse_mesh(z_up, "still.glb").mesh;
  const Vec3f p = usual.positions.front();
  EXPECT_EQ(lying.positions.front(), (Vec3f{p.x, -p.z, p.y}));
}

TEST(WriteGlb, WritesVertexColoursAndMeshesWithoutNormals) {
  const tests::TemporaryFolder folder("glb");
  Mesh made;
  made.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 2}};
  made.colours = {{1, 0, 0}, {0, .5F, 0}, {0, 0, .25F}};
  made.triangles = {{0, 1, 2}};
  made.triangle_material = {0};
  made.materials.resize(1);
  write_glb(made, folder.path() / "one.glb");
  const Mesh read = read_mesh(folder.path() / "one.glb").mesh;
  EXPECT_EQ(read.positions, made.positions);
  EXPECT_EQ(read.colours, made.colours);
  EXPECT_EQ(read.triangles, made.triangles);
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh
