#include "enfilade/mesh/mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>

namespace enfilade::mesh {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// A square of 2 m at z = 1, of two triangles.
Mesh square() {
  Mesh mesh;
  mesh.positions = {{0, 0, 1}, {2, 0, 1}, {2, 2, 1}, {0, 2, 1}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  mesh.triangle_material = {0, 0};
  mesh.materials.resize(1);
  return mesh;
}

std::vector<std::string> codes(const Mesh& mesh) {
  std::vector<std::string> out;
  for (const Diagnostic& d : check(mesh, "m.obj")) out.push_back(d.code);
  return out;
}

TEST(Mesh, BoundsAreThoseOfTriangles) {
  Mesh mesh = square();
  mesh.positions.push_back({9, 9, 9});  // of no triangle
  EXPECT_EQ(bounds(mesh).low, (Vec3f{0, 0, 1}));
  EXPECT_EQ(bounds(mesh).high, (Vec3f{2, 2, 1}));
}

TEST(Mesh, AppendMovesIndices) {
  Mesh mesh = square(), part = square();
  mesh.objects = {{"floor", 2, 0}};
  mesh.triangle_object = {0, kNoObject};
  part.objects = {{"table", 5, 1}, {"chair", 3, 1}};
  part.triangle_object = {1, kNoObject};
  part.materials[0].name = "oak";
  append(mesh, part);
  EXPECT_EQ(mesh.positions.size(), 8U);
  EXPECT_EQ(mesh.triangles[2], (std::array<std::uint32_t, 3>{4, 5, 6}));
  EXPECT_THAT(mesh.triangle_material, ElementsAre(0, 0, 1, 1));
  EXPECT_THAT(mesh.triangle_object, ElementsAre(0, kNoObject, 2, kNoObject));
  EXPECT_EQ(mesh.objects[2].name, "chair");
  EXPECT_EQ(mesh.materials[1].name, "oak");
  EXPECT_THAT(codes(mesh), IsEmpty());
}

TEST(Mesh, AppendFillsUpWhatOneLacks) {
  Mesh mesh = square(), part = square();
  part.texture_points.resize(2, {{{0, 0}, {1, 0}, {1, 1}}});
  part.normals.resize(2, {{{1, 0, 0}, {1, 0, 0}, {1, 0, 0}}});
  part.colours.resize(4, {0.5F, 0.5F, 0.5F});
  part.objects.resize(1);
  part.triangle_object = {0, 0};
  Mesh other = part;
  append(mesh, part);
  append(other, square());
  EXPECT_THAT(codes(mesh), IsEmpty());
  EXPECT_THAT(codes(other), IsEmpty());
  EXPECT_EQ(mesh.colours[0], (Vec3f{1, 1, 1}));
  EXPECT_EQ(mesh.colours[4], (Vec3f{0.5F, 0.5F, 0.5F}));
  EXPECT_EQ(mesh.normals[0][2], (Vec3f{0, 0, 1})) << "of the triangle itself";
  EXPECT_EQ(mesh.normals[2][2], (Vec3f{1, 0, 0}));
  EXPECT_EQ(other.normals[3][1], (Vec3f{0, 0, 1}));
  EXPECT_EQ(mesh.texture_points[3][2].v, 1);
  EXPECT_THAT(mesh.triangle_object, ElementsAre(kNoObject, kNoObject, 0, 0));
  EXPECT_THAT(other.triangle_object, ElementsAre(0, 0, kNoObject, kNoObject));
}

TEST(Mesh, AppendTakesItself) {
  Mesh mesh = square();
  append(mesh, mesh);
  EXPECT_EQ(mesh.triangles.size(), 4U);
  EXPECT_EQ(mesh.triangles[3], (std::array<std::uint32_t, 3>{4, 6, 7}));
  EXPECT_THAT(codes(mesh), IsEmpty());
}

TEST(Mesh, AppendToNothingIsThePart) {
  Mesh mesh, part = square();
  part.colours.resize(4, {0.5F, 0.5F, 0.5F});
  append(mesh, part);
  EXPECT_EQ(mesh.colours, part.colours);
  EXPECT_EQ(mesh.triangles, part.triangles);
}

TEST(MeshCheck, NamesEachError) {
  EXPECT_THAT(codes(square()), IsEmpty());
  EXPECT_THAT(codes(Mesh{}), ElementsAre("no-triangles"));
  const auto after = [](auto change) {
    Mesh mesh = square();
    change(mesh);
    return codes(mesh);
  };
  const float nan = std::nanf("");
  EXPECT_THAT(after([](Mesh& m) { m.triangles[1][2] = 4; }), ElementsAre("bad-index"));
  EXPECT_THAT(after([](Mesh& m) { m.triangle_material[0] = 1; }), ElementsAre("bad-index"));
  EXPECT_THAT(after([](Mesh& m) { m.triangle_object = {kNoObject, 0}; }), ElementsAre("bad-index"));
  EXPECT_THAT(after([&](Mesh& m) { m.positions[3].y = nan; }), ElementsAre("not-finite"));
  EXPECT_THAT(after([](Mesh& m) {
                m.colours.resize(4, {INFINITY, 0, 0});
              }),
              ElementsAre("not-finite"));
  EXPECT_THAT(after([&](Mesh& m) {
                m.normals.resize(2, {{{nan, 0, 0}, {}, {}}});
              }),
              ElementsAre("not-finite"));
  EXPECT_THAT(after([&](Mesh& m) {
                m.texture_points.resize(2, {{{0, nan}, {}, {}}});
              }),
              ElementsAre("not-finite"));
  EXPECT_THAT(after([](Mesh& m) { m.triangle_material.pop_back(); }), ElementsAre("list-length"));
  EXPECT_THAT(after([](Mesh& m) { m.colours.resize(3); }), ElementsAre("list-length"));
  EXPECT_THAT(after([&](Mesh& m) {
                m.positions.push_back({nan, 0, 0});
              }),
              IsEmpty())
      << "no triangle has it";
}

TEST(MeshCheck, NamesEachBadMaterial) {
  const auto after = [](auto change) {
    Mesh mesh = square();
    change(mesh.materials[0]);
    return codes(mesh);
  };
  EXPECT_THAT(after([](Material& m) { m.colour.x = 1.1F; }), ElementsAre("bad-material"));
  EXPECT_THAT(after([](Material& m) { m.colour.z = std::nanf(""); }), ElementsAre("bad-material"));
  EXPECT_THAT(after([](Material& m) { m.emission.y = -1; }), ElementsAre("bad-material"));
  EXPECT_THAT(after([](Material& m) { m.emission.y = INFINITY; }), ElementsAre("bad-material"));
  EXPECT_THAT(after([](Material& m) { m.mirror = 2; }), ElementsAre("bad-material"));
  EXPECT_THAT(after([](Material& m) { m.cutout = 0.5F; }), ElementsAre("bad-material"));
  EXPECT_THAT(after([](Material& m) { m.texture = image::Image8(2, 2, 1); }),
              ElementsAre("bad-material"));
  EXPECT_THAT(after([](Material& m) {
                m.texture = image::Image8(2, 2, 3);
                m.texture.pixels.pop_back();
              }),
              ElementsAre("bad-material"));
  EXPECT_THAT(after([](Material& m) {
                m.texture = image::Image8(2, 2, 4);
                m.cutout = 0.5F;
              }),
              IsEmpty());
}

TEST(MeshCheck, WarnsOfAbsurdSizesAndFlatTriangles) {
  Mesh mesh = square();
  mesh.triangles.push_back({0, 1, 1});
  mesh.triangle_material.push_back(0);
  ASSERT_THAT(codes(mesh), ElementsAre("degenerate-triangles"));
  const Diagnostic flat = check(mesh, "m.obj").front();
  EXPECT_EQ(flat.severity, Severity::kWarning);
  EXPECT_EQ(flat.file, "m.obj");
  EXPECT_THAT(flat.message, HasSubstr("1 of 3 triangles"));
  for (const float scale : {0.1F, 1000.0F}) {  // 0.28 m, 2.8 km
    Mesh scaled = square();
    for (Vec3f& p : scaled.positions) p = {p.x * scale, p.y * scale, p.z * scale};
    EXPECT_THAT(codes(scaled), ElementsAre("absurd-size"));
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh
