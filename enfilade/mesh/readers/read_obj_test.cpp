#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <filesystem>

#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"
#include "enfilade/mesh/read_mesh.h"
#include "enfilade/mesh/readers/reader.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::mesh::readers {
namespace EN_UNIT {

using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

constexpr const char* kCorners = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\n";

ReadResult parse(const std::string& text) { return parse_mesh(text, "a.obj"); }
std::vector<std::string> codes(const ReadResult& r) {
  std::vector<std::string> out;
  for (const Diagnostic& d : r.warnings) out.push_back(d.code);
  return out;
}

TEST(ReadObj, ReadsPolygonsAndNegativeIndices) {
  const ReadResult r = parse(std::string(kCorners) +
                             "# a comment\nvt 0 0\nvt 1 0.25\nvn 0 0 2\nf -4/1/1 -3/-1 \\\n -2//1 "
                             "4\ns off\n");
  EXPECT_THAT(r.mesh.triangles, ElementsAre(std::array{0U, 1U, 2U}, std::array{0U, 2U, 3U}));
  EXPECT_EQ(r.mesh.texture_points[0][0].v, 1) << "v goes up in the file and down here";
  EXPECT_EQ(r.mesh.texture_points[0][1].u, 1);
  EXPECT_EQ(r.mesh.texture_points[0][1].v, 0.75F);
  EXPECT_EQ(r.mesh.normals[0][0], (Vec3f{0, 0, 1}));
  EXPECT_EQ(r.mesh.normals[0][1], (Vec3f{0, 0, 1})) << "the triangle's own, as it has none";
  EXPECT_EQ(r.mesh.materials.size(), 1U);
  EXPECT_THAT(r.mesh.objects, IsEmpty());
  EXPECT_THAT(r.mesh.triangle_object, IsEmpty());
  EXPECT_THAT(r.mesh.colours, IsEmpty());
  EXPECT_THAT(r.warnings, IsEmpty());
}

TEST(ReadObj, LeavesOutListsThatNoFaceUses) {
  const Mesh m = parse(std::string(kCorners) + "vt 0 0\nvn 0 0 1\nf 1 2 3\n").mesh;
  EXPECT_THAT(m.texture_points, IsEmpty());
  EXPECT_THAT(m.normals, IsEmpty());
}

// A polygon that goes round four points a million times took 33 s of tracing rays: half of its
// triangles lie on each other.
TEST(ReadObj, DropsCopiesOfATriangleBeyondTheSixtyFourth) {
  std::string face = "f";
  for (int k = 0; k < 4000; ++k) face += " " + std::to_string(k % 4 + 1);
  const ReadResult r = parse(kCorners + face + "\nf 1 2 3\n");
  EXPECT_LE(r.mesh.triangles.size(), 5 * kMostCopies);
  EXPECT_EQ(r.mesh.triangle_material.size(), r.mesh.triangles.size());
  EXPECT_THAT(codes(r), ElementsAre("degenerate-triangles", "repeated-triangles"));
  // As many of each as exporters may write, whatever their objects, order of corners and signs of
  // zeros; and more of different materials.
  std::string twice = kCorners;
  for (std::uint32_t k = 0; k < kMostCopies; ++k) twice += "f 1 2 3\nf 1 3 4\n";
  twice += "g other\nf 1 2 3\nf 1 3 4\nv -0 0 -0\ng\nf 3 2 1\nf 3 4 1\nf 2 3 5\n";
  EXPECT_EQ(parse(twice).mesh.triangles.size(), 2 * kMostCopies);
  const ReadResult more = parse(twice + "vt 0.5 0.5\nf 1/1 2/1 3/1\nusemtl b\nf 1 2 3\nf 1 2 3\n");
  EXPECT_EQ(more.mesh.triangles.size(), 2 * kMostCopies + 2);
  EXPECT_EQ(more.mesh.texture_points.size(), more.mesh.triangles.size());
}

TEST(ReadObj, LargePolygonsAreFans) {
  std::string text, face = "f";
  for (int i = 0; i < 300; ++i) {  // more corners than a byte counts
    text += "v " + std::to_string(i) + " " + std::to_string(i * i) + " 0\n";
    face += " " + std::to_string(i + 1);
  }
  const Mesh m = parse(text + face + "\n").mesh;
  ASSERT_EQ(m.triangles.size(), 298U);
  EXPECT_EQ(m.triangles.back(), (std::array{0U, 298U, 299U}));
}

TEST(ReadObj, GroupsAreObjects) {
  const ReadResult r = parse(std::string(kCorners) +
                             "f 1 2 3\ng empty\no table 1\nf 1 2 3\ng\nf 1 2 3\ng chair left\n"
                             "f 1 2 3\no table 1\nf 1 2 3\n");
  ASSERT_EQ(r.mesh.objects.size(), 2U);
  EXPECT_EQ(r.mesh.objects[0].name, "table 1");
  EXPECT_EQ(r.mesh.objects[1].name, "chair left");
  EXPECT_THAT(r.mesh.triangle_object, ElementsAre(kNoObject, 0, kNoObject, 1, 0));
}

TEST(ReadObj, ReadsColoursOfPositions) {
  const Mesh m = parse("v 0 0 0 1 0 0.5\nv 2 0 0\nv 2 2 0\nf 1 2 3\n").mesh;
  EXPECT_EQ(m.colours[0].x, 1);
  EXPECT_NEAR(m.colours[0].z, 0.21404, 1e-5);  // sRGB's 0.5
  EXPECT_EQ(m.colours[1], (Vec3f{1, 1, 1}));
}

TEST(ReadObj, WarnsOfWhatItLeavesOut) {
  const ReadResult r = parse(std::string(kCorners) +
                             "l 1 2\nl 1 2\np 1\nwhat 1\nf 1 2\nusemtl gone\nf 1 2 3\n"
                             "mtllib other.mtl\n");
  EXPECT_THAT(r.warnings, Contains(Field(&Diagnostic::message, HasSubstr("2 l lines"))));
  EXPECT_THAT(r.warnings, Contains(Field(&Diagnostic::message, HasSubstr("fewer than 3 corners"))));
  EXPECT_THAT(r.warnings,
              Contains(Field(&Diagnostic::message, HasSubstr("material \"gone\" is in no .mtl"))));
  EXPECT_THAT(r.warnings, Contains(Field(&Diagnostic::message, HasSubstr("\"other.mtl\""))));
  EXPECT_EQ(r.mesh.materials[0].name, "gone");
}

TEST(ReadObj, NamesLineAndFault) {
  const auto faulty = [](const std::string& text) {
    return [=] { parse(kCorners + text + "\nf 1 2 3\n"); };
  };
  const auto says = [](const char* text) { return ThrowsMessage<InvalidInput>(HasSubstr(text)); };
  EXPECT_THAT(faulty("f 1 2 5"), says("a.obj: line 5: position \"5\", not one of the 4 before it"));
  EXPECT_THAT(faulty("f 1 2 -5"), says("position \"-5\""));
  EXPECT_THAT(faulty("f 1 2 0"), says("position \"0\""));
  EXPECT_THAT(faulty("f 1 2 99999999999999999999"), says("position \"99999999999999999999\""));
  EXPECT_THAT(faulty("f a b c"), says("position \"a\""));
  EXPECT_THAT(faulty("v 1 nan 0\nf 1 2 5"),
              says("line 5: \"nan\", not a finite number, and the face of line 6 uses it"));
  EXPECT_THAT(faulty("v 1 2\nf 5 2 1"), says("line 5: 2 numbers, not 3"));
  EXPECT_THAT(faulty("v 1 1e39 0\nf 1 2 5"), says("\"1e39\""));  // too large for a float
  EXPECT_THAT([] { parse("v 1 2 3\n"); }, says("[no-triangles]"));
  EXPECT_THAT([] { parse(""); }, says("[no-triangles]"));
}

/// How programs write numbers that are not finite.
constexpr std::array kNotFinite{"nan",       "-nan",  "NaN",       "nan(ind)", "-nan(ind)",
                                "1.#QNAN",   "-1.#J", "-1.#IND00", "1.#INF",   "inf",
                                "-Infinity", "1e999", "abc"};

TEST(ReadObj, NumbersThatAreNotFiniteAreWarnings) {
  for (const std::string odd : kNotFinite) {
    const ReadResult r = parse(std::string(kCorners) + "vt " + odd + " 0.25\nvn 0 " + odd +
                               " 1\nvn " + odd + " 0 0\nv 5 " + odd + " 5\nf 1/1/1 2/1 3//1 4\n");
    EXPECT_THAT(codes(r), ElementsAre("not-finite", "not-finite", "not-finite")) << odd;
    EXPECT_EQ(r.mesh.texture_points[0][0].u, 0) << odd;
    EXPECT_EQ(r.mesh.texture_points[0][0].v, 0.75F) << odd;
    EXPECT_EQ(r.mesh.normals[0][0], (Vec3f{0, 0, 1})) << odd << ": the face's";
    EXPECT_EQ(r.mesh.positions[4], (Vec3f{})) << odd << ": no face uses it";
    EXPECT_EQ(r.warnings[1].where, "line 6");
    EXPECT_THAT(r.warnings[1].message, HasSubstr("2 normals"));
  }
  EXPECT_EQ(parse("v 1e-999 0 0\nv 2 0 0\nv 2 2 0\nf 1 2 3\n").mesh.positions[0], (Vec3f{}));
}

TEST(ReadObj, PositionsThatAreNotFiniteAreErrorsWhereFacesUseThem) {
  for (const std::string odd : kNotFinite) {
    EXPECT_THAT([&] { parse("v 0 0 " + odd + "\nv 2 0 0\nv 2 2 0\nf 1 2 3\nf 1 3 2\n"); },
                ThrowsMessage<InvalidInput>(HasSubstr("line 1: \"" + odd + "\", not a finite")))
        << odd;
  }
}

TEST(ReadObj, NormalsAndTexturePointsThatAreMissingAreWarnings) {
  const ReadResult r =
      parse(std::string(kCorners) + "vt 1 1\nvn 1 0 0\nf 1/1/1 2/7/-3 3/x/0\nf 1 2 4 # back\n");
  EXPECT_THAT(codes(r), ElementsAre("bad-index", "bad-index"));
  EXPECT_THAT(r.warnings[0].message, HasSubstr("2 corners name a normal"));
  EXPECT_EQ(r.mesh.normals[0][0], (Vec3f{1, 0, 0}));
  EXPECT_EQ(r.mesh.normals[0][1], (Vec3f{0, 0, 1}));
  EXPECT_EQ(r.mesh.triangles.size(), 2U);
}

TEST(ReadObj, ColoursOfBytesAreDivided) {
  const ReadResult r = parse("v 0 0 0 255 0 0\nv 2 0 0 0 0 255\nv 2 2 0 nan 0 0\nf 1 2 3\n");
  EXPECT_THAT(codes(r), ElementsAre("not-finite", "colour-bytes"));
  EXPECT_EQ(r.warnings[1].severity, Severity::kNote);
  EXPECT_EQ(r.mesh.colours[0], (Vec3f{1, 0, 0}));
  EXPECT_EQ(r.mesh.colours[1], (Vec3f{0, 0, 1}));
  EXPECT_EQ(r.mesh.colours[2], (Vec3f{1, 1, 1}));
  const ReadResult shares = parse("v 0 0 0 1.0001 0 0\nv 2 0 0\nv 2 2 0\nf 1 2 3\n");
  EXPECT_EQ(shares.mesh.colours[0], (Vec3f{1, 0, 0}));
  EXPECT_THAT(shares.warnings, IsEmpty());
}

TEST(ReadObj, ReadsByteOrderMarksAndOldLineEnds) {
  const std::string text = std::string(kCorners) + "f 1 2 3\n";
  EXPECT_THAT(parse("\xEF\xBB\xBF" + text).warnings, IsEmpty());
  std::string old = text;
  std::ranges::replace(old, '\n', '\r');
  EXPECT_EQ(parse(old).mesh.triangles.size(), 1U);
  std::string wide = "\xFE\xFF";
  for (const char c : text) (wide += '\0') += c;
  EXPECT_EQ(parse(wide).mesh.positions, parse(text).mesh.positions);
  EXPECT_EQ(parse(wide).mesh.triangles.size(), 1U);
}

TEST(ReadObj, WarnsOfAbsurdScaleAndTakesAnother) {
  const std::string millimetres = "v 0 0 0\nv 9000 0 0\nv 0 7000 0\nf 1 2 3\n";
  EXPECT_THAT(codes(parse(millimetres)), ElementsAre("absurd-size"));
  ReadOptions options;
  options.scale = 0.001;
  options.up = UpAxis::kY;
  const ReadResult r = parse_mesh(millimetres, "a.obj", options);
  EXPECT_THAT(r.warnings, IsEmpty());
  EXPECT_EQ(r.mesh.positions[2], (Vec3f{0, 0, 7}));
}

/// Files beside an OBJ.
class ObjFolder : public ::testing::Test {
 protected:
  void write(const char* name, std::string_view text) const {
    write_file_atomically(folder_ / name, text);
  }
  void write(const char* name, const std::vector<std::uint8_t>& bytes) const {
    write(name, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  }
  ReadResult read(const char* name) const { return read_mesh(folder_ / name); }
  const tests::TemporaryFolder made_{"obj"};
  const std::filesystem::path& folder_ = made_.path();
};

TEST_F(ObjFolder, ReadsMaterialsAndTextures) {
  image::Image8 grey(2, 2, 2);
  grey.pixels = {10, 255, 20, 0, 30, 255, 40, 0};
  write("leaf 1.png", image::encode_png(grey));
  write("my lib.mtl",
        "newmtl leaf\nKd 0.5\nmap_Kd -s 2 2 -bm 1.5 leaf 1.png\nmap_d leaf 1.png\n\n"
        "newmtl lamp\n  Kd 1 0.5 0.25\nKe 3 2 1\nKs 0.5 0.5 0.5\nillum 3\n");
  write("a.obj", std::string("mtllib my lib.mtl\n") + kCorners +
                     "vt 0 0\nusemtl lamp\nf 1 2 3\nusemtl leaf\nf 1/1 3/1 4/1\n");
  const ReadResult r = read("a.obj");
  ASSERT_EQ(r.mesh.materials.size(), 2U);
  EXPECT_THAT(r.mesh.triangle_material, ElementsAre(1, 0));
  const Material& leaf = r.mesh.materials[0];
  EXPECT_EQ(leaf.colour, (Vec3f{0.5F, 0.5F, 0.5F}));
  EXPECT_EQ(leaf.cutout, 0.5F);
  EXPECT_EQ(leaf.texture_file, (folder_ / "leaf 1.png").string());
  ASSERT_EQ(leaf.texture.channels, 4U);
  EXPECT_THAT(std::vector(leaf.texture.at(1, 0), leaf.texture.at(1, 0) + 4),
              ElementsAre(20, 20, 20, 0));
  const Material& lamp = r.mesh.materials[1];
  EXPECT_EQ(lamp.colour, (Vec3f{1, 0.5F, 0.25F}));
  EXPECT_EQ(lamp.emission, (Vec3f{3, 2, 1}));
  EXPECT_EQ(lamp.mirror, 0.5F);
  EXPECT_THAT(codes(r), ElementsAre("bad-material"));  // -s is not looked at
}

TEST_F(ObjFolder, ReadsMaterialsInUtf16) {
  std::string wide = "\xFE\xFF";
  for (const char c : std::string("newmtl a\nKd 1 0.5 0.25\n")) (wide += '\0') += c;
  write("a.mtl", wide);
  write("a.obj", std::string("mtllib a.mtl\n") + kCorners + "usemtl a\nf 1 2 3\n");
  const ReadResult r = read("a.obj");
  EXPECT_EQ(r.mesh.materials[0].colour, (Vec3f{1, 0.5F, 0.25F}));
  EXPECT_THAT(r.warnings, IsEmpty());
}

TEST_F(ObjFolder, MissingAndBrokenTexturesAreWarnings) {
  write("broken.jpg", "\xFF\xD8 no more");
  write("text.png", "hello");
  write("a.mtl",
        "newmtl a\nKd 0.1 0.2 0.3\nmap_Kd gone.png\nnewmtl b\nmap_Kd broken.jpg\n"
        "newmtl c\nmap_Kd text.png\nKd red\n newmtl d\nmap_Kd .\nKd 2 0 0\n");
  write("a.obj", std::string(kCorners) + "mtllib a.mtl none.mtl\nusemtl a\nf 1 2 3\n");
  const ReadResult r = read("a.obj");
  EXPECT_EQ(r.mesh.materials[0].colour, (Vec3f{0.1F, 0.2F, 0.3F}));
  EXPECT_TRUE(r.mesh.materials[0].texture.pixels.empty());
  EXPECT_EQ(r.mesh.materials[0].texture_file, "");
  EXPECT_THAT(codes(r),
              ElementsAre("bad-material", "bad-material", "missing-texture", "missing-texture",
                          "missing-texture", "missing-texture", "missing-material"));
  for (const char* part : {"gone.png", "neither a JPEG nor a PNG", "Kd \"red\", not 0"}) {
    EXPECT_THAT(r.warnings, Contains(Field(&Diagnostic::message, HasSubstr(part))));
  }
}

TEST_F(ObjFolder, ReadsMaterialsOfProgramsForWindows) {
  image::Image8 red(1, 1, 3);
  red.pixels = {255, 0, 0};
  std::filesystem::create_directories(folder_ / "maps");
  write("tex.png", image::encode_png(red));
  write("maps/Oak.PNG", image::encode_png(red));
  write("Room.MTL",
        "\xEF\xBB\xBFnewmtl moved\nKD 0.5 0.5 0.5 # grey\nmap_kd C:\\Users\\a b\\TEX.png\n"
        "newmtl below\nmap_Kd .\\Maps\\oak.png\nnewmtl gone\nmap_Kd D:\\none.png\n");
  write("a.obj", std::string("mtllib .\\room.mtl\n") + kCorners +
                     "vt 0 0\nusemtl moved\nf 1/1 2/1 3/1\nusemtl below\nf 1/1 3/1 4/1\n");
  const ReadResult r = read("a.obj");
  EXPECT_THAT(codes(r), ElementsAre("moved-file", "moved-file", "missing-texture", "moved-file"));
  EXPECT_EQ(r.warnings[0].severity, Severity::kNote);
  EXPECT_THAT(r.warnings[0].message, HasSubstr("is read from " + (folder_ / "tex.png").string()));
  EXPECT_EQ(r.mesh.materials[0].name, "moved");
  EXPECT_EQ(r.mesh.materials[0].colour, (Vec3f{0.5F, 0.5F, 0.5F}));
  EXPECT_EQ(r.mesh.materials[0].texture, red);
  EXPECT_EQ(r.mesh.materials[1].texture_file, (folder_ / "maps" / "Oak.PNG").string());
}

TEST_F(ObjFolder, TexturesMayLieBesideTheirLibrary) {
  image::Image8 red(1, 1, 3);
  std::filesystem::create_directories(folder_ / "lib");
  write("lib/tex.png", image::encode_png(red));
  write("lib/a.mtl", "newmtl a\nmap_Kd tex.png\n");
  write("a.obj",
        std::string("mtllib lib/a.mtl\n") + kCorners + "vt 0 0\nusemtl a\nf 1/1 2/1 3/1\n");
  const ReadResult r = read("a.obj");
  EXPECT_THAT(r.warnings, IsEmpty());
  EXPECT_EQ(r.mesh.materials[0].texture, red);
}

TEST_F(ObjFolder, ReadsWhatItWrites) {
  Mesh m;
  m.positions = {{0, 0, 0.1F}, {2, 0, 0}, {2, 2, 0}, {0, 2.125F, 0}};
  m.triangles = {{0, 1, 2}, {0, 2, 3}, {1, 2, 3}};
  m.triangle_material = {1, 0, 1};
  m.triangle_object = {1, kNoObject, 0};
  m.texture_points = {{{{0, 0.25F}, {1, 0}, {1, 1}}}, {}, {{{3, -2}, {0.5F, 0.5F}, {0, 0}}}};
  m.normals.assign(3, {{{0, 0, 1}, {0, 0.6F, 0.8F}, {1, 0, 0}}});
  m.colours = {{1, 1, 1}, {0.5F, 0.25F, 0.125F}, {0, 0, 0}, {0.001F, 1, 1}};
  m.objects = {{"a big table", 5, 0}, {"lamp", 28, 0}};
  m.materials.resize(2);
  m.materials[0].name = "same name";
  m.materials[0].emission = {5, 4, 3};
  m.materials[0].mirror = 0.25F;
  m.materials[1].name = "same name";
  m.materials[1].colour = {0.25F, 0.5F, 1};
  m.materials[1].texture = image::Image8(3, 2, 4);
  m.materials[1].texture.pixels[5] = 77;
  m.materials[1].cutout = 0.5F;
  write_obj(m, folder_ / "deep" / "er", "home");
  const ReadResult r = read_mesh(folder_ / "deep" / "er" / "home.obj");
  EXPECT_THAT(r.warnings, IsEmpty());
  EXPECT_EQ(r.mesh.positions, m.positions);
  EXPECT_THAT(r.mesh.triangles, ElementsAre(m.triangles[1], m.triangles[2], m.triangles[0]));
  EXPECT_THAT(r.mesh.triangle_material, ElementsAre(0, 1, 1));
  EXPECT_THAT(r.mesh.triangle_object, ElementsAre(kNoObject, 0, 1));
  EXPECT_EQ(r.mesh.objects[0].name, "0_a_big_table");
  EXPECT_EQ(r.mesh.objects[1].name, "1_lamp");
  EXPECT_EQ(r.mesh.texture_points[1][0].u, 3);
  EXPECT_EQ(r.mesh.texture_points[1][0].v, -2);
  EXPECT_EQ(r.mesh.texture_points[2][0].v, 0.25F);
  EXPECT_EQ(r.mesh.normals[0], m.normals[0]);
  for (std::size_t i = 0; i < 4; ++i) {  // through sRGB and back in single precision
    EXPECT_NEAR(r.mesh.colours[i].x, m.colours[i].x, 1e-6);
    EXPECT_NEAR(r.mesh.colours[i].y, m.colours[i].y, 1e-6);
  }
  EXPECT_EQ(r.mesh.materials[0].emission, m.materials[0].emission);
  EXPECT_EQ(r.mesh.materials[0].mirror, 0.25F);
  EXPECT_EQ(r.mesh.materials[1].texture, m.materials[1].texture) << "PNG loses nothing";
  EXPECT_EQ(r.mesh.materials[1].cutout, 0.5F);
}

TEST_F(ObjFolder, WritingWhereNoFolderCanBeIsAFileError) {
  write("file", "");
  EXPECT_THROW(write_obj(Mesh{}, folder_ / "file" / "x", "a"), FileError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh::readers
