#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

#include "enfilade/core/file.h"
#include "enfilade/image/codecs.h"
#include "enfilade/mesh/read_mesh.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::mesh::readers {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

template <class T>
void put(std::string& out, T value, bool big) {
  std::string raw(reinterpret_cast<const char*>(&value), sizeof(T));  // little-endian here
  if (big) std::reverse(raw.begin(), raw.end());
  out += raw;
}

/// A square of 2 m as one polygon, with an element and properties that nobody knows in between.
std::string binary_square(bool big) {
  std::string out = "ply\r\nformat binary_";
  out += big ? "big" : "little";
  out +=
      "_endian 1.0\r\nobj_info x\r\nelement vertex 4\r\nproperty double z\r\n"
      "property short quality\r\nproperty float x\r\nproperty float y\r\n"
      "property list uint16 int16 friends\r\nelement secret 2\r\nproperty list char double d\r\n"
      "element face 1\r\nproperty uint flags\r\nproperty list int uint vertex_indices\r\n"
      "end_header\r\n";
  const float xy[4][2] = {{0, 0}, {2, 0}, {2, 2}, {0, 2}};
  for (const auto& [x, y] : xy) {
    put(out, 1.5, big);
    put(out, std::int16_t{-1}, big);
    put(out, x, big);
    put(out, y, big);
    put(out, std::uint16_t{2}, big);
    put(out, std::int16_t{-7}, big);
    put(out, std::int16_t{7}, big);
  }
  for (const std::int8_t n : {std::int8_t{0}, std::int8_t{1}}) {
    put(out, n, big);
    for (int k = 0; k < n; ++k) put(out, 0.5, big);
  }
  put(out, std::uint32_t{1}, big);
  put(out, std::int32_t{4}, big);
  for (const std::uint32_t v : {0U, 1U, 2U, 3U}) put(out, v, big);
  return out;
}

TEST(ReadPly, ReadsBothByteOrdersAndSkipsWhatIsUnknown) {
  for (const bool big : {false, true}) {
    const ReadResult r = parse_mesh(binary_square(big), "a.ply");
    EXPECT_THAT(r.mesh.triangles, ElementsAre(std::array{0U, 1U, 2U}, std::array{0U, 2U, 3U}));
    EXPECT_EQ(r.mesh.positions[2], (Vec3f{2, 2, 1.5F}));
    EXPECT_EQ(r.mesh.materials.size(), 1U);
    EXPECT_THAT(r.mesh.objects, IsEmpty());
    ASSERT_EQ(r.warnings.size(), 1U);
    EXPECT_EQ(r.warnings[0].code, "left-out");
    EXPECT_EQ(r.warnings[0].where, "element secret");
  }
}

TEST(ReadPly, CutAnywhereIsRefused) {
  for (const bool big : {false, true}) {
    const std::string bytes = binary_square(big);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      // Of its own allocation, so that a sanitizer sees a step over the end.
      const std::string cut = bytes.substr(0, size);
      EXPECT_THROW(parse_mesh(cut, "a.ply"), InvalidInput) << size;
    }
  }
}

constexpr const char* kHeader =
    "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
    "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
    "property ushort red\nproperty ushort green\nproperty ushort blue\nelement face 2\n"
    "property list uchar int vertex_indices\nend_header\n";
std::string ascii(const std::string& first, const std::string& face) {
  return kHeader + first + "\n1 0 0 0 0 2 0 0 0\n\n1 1 0 0 0 1 0 0 0\n0 1 0 0 0 1 0 0 0\n" + face +
         "\n3 0 2 3\n";
}

TEST(ReadPly, ReadsColoursAndNormals) {
  const ReadResult r = parse_mesh(ascii("0 0 0 0 3 4 65535 0 32768", "3 0 1 2"), "A.PLY");
  EXPECT_EQ(r.mesh.normals[0][0], (Vec3f{0, 0.6F, 0.8F}));
  EXPECT_EQ(r.mesh.normals[0][1], (Vec3f{0, 0, 1}));
  EXPECT_EQ(r.mesh.colours[0].x, 1);
  // sRGB's curve at one half.
  EXPECT_NEAR(r.mesh.colours[0].z, std::pow((0.5 + 0.055) / 1.055, 2.4), 1e-5);
  EXPECT_EQ(r.mesh.materials[0].colour, (Vec3f{1, 1, 1}));
  EXPECT_THAT(r.warnings, IsEmpty());
}

TEST(ReadPly, NormalsOfNoLengthAreThoseOfTheFace) {
  const ReadResult r = parse_mesh(ascii("0 0 0 0 0 0 1 1 1", "3 0 1 2"), "a.ply");
  EXPECT_EQ(r.mesh.normals[0][0], (Vec3f{0, 0, 1}));
  EXPECT_THAT(r.warnings, IsEmpty());
  std::string none = ascii("0 0 0 0 0 0 1 1 1", "3 0 1 2");
  for (const char* normal : {"0 0 2", "0 0 1", "0 0 1"}) {
    none.replace(none.find(normal, none.find("end_header") + 20), 5, "0 0 0");
  }
  EXPECT_THAT(parse_mesh(none, "a.ply").mesh.normals, IsEmpty());
}

std::vector<std::string> codes(const ReadResult& r) {
  std::vector<std::string> out;
  for (const Diagnostic& d : r.warnings) out.push_back(d.code);
  return out;
}

TEST(ReadPly, NumbersThatAreNotFiniteAreWarnings) {
  for (const std::string odd : {"nan", "-nan(ind)", "1.#QNAN", "-1.#IND", "inf", "1e999"}) {
    const ReadResult r =
        parse_mesh(ascii("0 0 0 " + odd + " 0 1 7 " + odd + " 7", "3 0 1 2"), "a.ply");
    EXPECT_THAT(codes(r), ElementsAre("not-finite", "not-finite")) << odd;
    EXPECT_EQ(r.warnings[0].where, "vertex 0");
    EXPECT_EQ(r.mesh.normals[0][0], (Vec3f{0, 0, 1})) << "the face's";
    EXPECT_EQ(r.mesh.colours[0], (Vec3f{1, 1, 1}));
    EXPECT_EQ(r.mesh.colours[1].y, 0);
    // A position that no face uses, and one that a face uses.
    const auto cut = [&](const std::string& face) {
      return parse_mesh(
          ascii("0 " + odd + " 0 0 0 1 7 7 7", face)
                  .substr(0, ascii("0 " + odd + " 0 0 0 1 7 7 7", face).rfind("3 0 2 3")) +
              "3 1 2 3\n",
          "a.ply");
    };
    EXPECT_THAT(codes(cut("3 1 2 3")), ElementsAre("not-finite")) << odd;
    EXPECT_THAT([&] { cut("3 0 1 2"); },
                ThrowsMessage<InvalidInput>(HasSubstr("face 0: vertex 0, whose position")));
  }
  const ReadResult word = parse_mesh(ascii("0 0 0 none 0 1 7 7 7", "3 0 1 2"), "a.ply");
  EXPECT_THAT(codes(word), ElementsAre("bad-value", "not-finite"));
  std::string unused = ascii("0 none 0 0 0 1 7 7 7", "3 1 2 3");
  unused.replace(unused.rfind("3 0 2 3"), 7, "3 3 2 1");
  EXPECT_THAT(codes(parse_mesh(unused, "a.ply")), ElementsAre("bad-value", "not-finite"));
}

TEST(ReadPly, FloatColoursOfBytesAreDivided) {
  const auto parse = [](const std::string& first) {
    std::string text = ascii(first, "3 0 1 2");
    for (int k = 0; k < 3; ++k) text.replace(text.find("ushort"), 6, "float");
    return parse_mesh(text, "a.ply");
  };
  const ReadResult bytes = parse("0 0 0 0 0 1 255 0 127.5");
  EXPECT_THAT(codes(bytes), ElementsAre("colour-bytes"));
  EXPECT_EQ(bytes.warnings[0].severity, Severity::kNote);
  EXPECT_EQ(bytes.mesh.colours[0].x, 1);
  EXPECT_NEAR(bytes.mesh.colours[0].z, std::pow((0.5 + 0.055) / 1.055, 2.4), 1e-5);
  EXPECT_THAT(codes(parse("0 0 0 0 0 1 255 0 inf")), ElementsAre("not-finite", "colour-bytes"));
  const ReadResult shares = parse("0 0 0 0 0 1 1.0001 0 0.5");
  EXPECT_THAT(shares.warnings, IsEmpty());
  EXPECT_EQ(shares.mesh.colours[0].x, 1);
}

TEST(ReadPly, MoreValuesAndFreeTextAreWarnings) {
  // MeshLab's header of 2010 lacks a property that its rows have.
  EXPECT_THAT(codes(parse_mesh(ascii("0 0 0 0 0 1 9 9 9 255", "3 0 1 2 255 0"), "a.ply")),
              ElementsAre("long-row"));
  std::string text = ascii("0 0 0 0 0 1 9 9 9", "3 0 1 2");
  text.replace(text.find("element vertex 4"), 16, "made by hand\nelement vertex 4 of them");
  const ReadResult r = parse_mesh(text, "a.ply");
  EXPECT_THAT(codes(r), ElementsAre("unknown-line"));
  EXPECT_THAT(r.warnings[0].message, HasSubstr("2 lines of the header"));
  EXPECT_EQ(r.warnings[0].where, "line 3");
}

/// A folder with a red and a green picture.
class PlyFolder : public ::testing::Test {
 protected:
  PlyFolder() {
    write_picture("red.png", {255, 0, 0});
    write_picture("green.png", {0, 255, 0});
  }
  ReadResult read(const std::string& header, const std::string& vertex_columns,
                  const std::string& face_columns, const std::array<std::string, 4>& vertices,
                  const std::array<std::string, 2>& faces) const {
    std::string text = "ply\nformat ascii 1.0\n" + header +
                       "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n" +
                       vertex_columns + "element face 2\nproperty list uchar int vertex_indices\n" +
                       face_columns + "end_header\n";
    const std::array<const char*, 4> places{"0 0 0", "2 0 0", "2 2 0", "0 2 0"};
    for (std::size_t i = 0; i < 4; ++i) text += places[i] + (" " + vertices[i]) + "\n";
    text += "3 0 1 2 " + faces[0] + "\n3 0 2 3 " + faces[1] + "\n";
    write_file_atomically(folder_ / "a.ply", text);
    return read_mesh(folder_ / "a.ply");
  }
  const tests::TemporaryFolder made_{"ply"};
  const std::filesystem::path& folder_ = made_.path();

 private:
  void write_picture(const char* name, const std::array<std::uint8_t, 3>& colour) const {
    image::Image8 picture(1, 1, 3);
    std::ranges::copy(colour, picture.pixels.begin());
    const auto bytes = image::encode_png(picture);
    write_file_atomically(folder_ / name, std::string(bytes.begin(), bytes.end()));
  }
};

TEST_F(PlyFolder, ReadsTexturesOfCorners) {  // as MeshLab writes them
  const ReadResult r = read(
      "comment VCGLIB generated\ncomment TextureFile red.png\ncomment TextureFile "
      "C:\\x\\Green.png\n",
      "", "property list uchar float texcoord\nproperty int texnumber\n", {},
      {"6 0 0 1 0 1 0.25 0", "6 0 0 1 nan 0 1 1"});
  EXPECT_THAT(codes(r), ElementsAre("not-finite", "moved-file"));
  ASSERT_EQ(r.mesh.materials.size(), 2U);
  EXPECT_THAT(r.mesh.triangle_material, ElementsAre(0, 1));
  EXPECT_EQ(r.mesh.materials[0].texture.pixels[0], 255);
  EXPECT_EQ(r.mesh.materials[1].texture.pixels[1], 255);
  EXPECT_EQ(r.mesh.materials[0].colour, (Vec3f{1, 1, 1}));
  EXPECT_EQ(r.mesh.texture_points[0][2].u, 1);
  EXPECT_EQ(r.mesh.texture_points[0][2].v, 0.75F) << "v goes up in the file and down here";
  EXPECT_EQ(r.mesh.texture_points[1][1].v, 1) << "not a number: 0 in the file";
}

TEST(ReadPly, ReadsMeshLabs) {  // written by MeshLab 2025.07, with texture points by corner
  const ReadResult r = read_mesh(std::filesystem::path(EN_SOURCE_DIR) / "tests" / "fuzz" / "seeds" /
                                 "mesh_ply" / "meshlab.ply");
  EXPECT_THAT(codes(r), ElementsAre("missing-texture"));
  EXPECT_EQ(r.mesh.triangles.size(), 2U);
  EXPECT_EQ(r.mesh.texture_points[0][2].v, 0.75F);
  EXPECT_EQ(r.mesh.texture_points[1][2].v, 0);
  EXPECT_EQ(r.mesh.normals[0][0], (Vec3f{0, 0, 1}));
}

TEST_F(PlyFolder, ReadsTexturesOfVertices) {
  for (const char* names :
       {"property float s\nproperty float t\n", "property float u\nproperty float v\n",
        "property float texture_u\nproperty float texture_v\n"}) {
    const ReadResult r =
        read("comment TextureFile red.png\n", names, "", {"0 0", "1 0", "1 0.25", "0 1"}, {});
    EXPECT_THAT(r.warnings, IsEmpty());
    EXPECT_EQ(r.mesh.texture_points[0][2].v, 0.75F);
    EXPECT_EQ(r.mesh.texture_points[1][2].v, 0);
  }
}

TEST_F(PlyFolder, TexturesThatCannotBeReadAreWarnings) {
  const ReadResult gone =
      read("comment TextureFile none.png\n", "property float s\nproperty float t\n", "",
           {"0 0", "1 0", "1 1", "0 1"}, {});
  EXPECT_THAT(codes(gone), ElementsAre("missing-texture"));
  EXPECT_THAT(gone.warnings[0].message, HasSubstr("none.png"));
  const ReadResult unnamed =
      read("", "property float s\nproperty float t\n", "", {"0 0", "1 0", "1 1", "0 1"}, {});
  EXPECT_THAT(codes(unnamed), ElementsAre("left-out"));
  EXPECT_THAT(codes(read("comment TextureFile red.png\n", "", "", {}, {})),
              ElementsAre("left-out"));
  const ReadResult number = read("comment TextureFile red.png\ncomment TextureFile green.png\n", "",
                                 "property list uchar float texcoord\nproperty int texnumber\n", {},
                                 {"6 0 0 1 0 1 0 9", "6 0 0 1 0 0 1 -1"});
  EXPECT_THAT(codes(number), ElementsAre("bad-index"));
}

TEST(ReadPly, BinaryNumbersMayBeNotFiniteWhereNoFaceUsesThem) {
  for (const bool big : {false, true}) {
    std::string x;
    put(x, std::numeric_limits<float>::quiet_NaN(), big);
    std::string bytes = binary_square(big);
    // A row has 24 bytes, 10 of them before x. The file ends with the corner at vertex 3.
    bytes.replace(bytes.find("end_header") + 12 + 3 * 24 + 10, 4, x);
    EXPECT_THAT([&] { parse_mesh(bytes, "a.ply"); },
                ThrowsMessage<InvalidInput>(HasSubstr("vertex 3, whose position is not finite")));
    std::string corner;
    put(corner, std::uint32_t{0}, big);
    const ReadResult r = parse_mesh(bytes.replace(bytes.size() - 4, 4, corner), "a.ply");
    EXPECT_THAT(codes(r), ::testing::Contains("not-finite"));
    EXPECT_EQ(r.mesh.positions[3], (Vec3f{}));
  }
}

TEST(ReadPly, ReadsTextWithAByteOrderMark) {
  const std::string text = ascii("0 0 0 0 0 1 9 9 9", "3 0 1 2");
  EXPECT_EQ(parse_mesh("\xEF\xBB\xBF" + text, "a.ply").mesh.triangles.size(), 2U);
  std::string wide = "\xFE\xFF";  // UTF-16
  for (const char c : text) (wide += '\0') += c;
  EXPECT_EQ(parse_mesh(wide, "a.ply").mesh.triangles.size(), 2U);
}

TEST(ReadPly, NamesEachFault) {
  const auto parse = [](std::string text) {
    return [text = std::move(text)] { parse_mesh(text, "a.ply"); };
  };
  const auto says = [](const char* text) { return ThrowsMessage<InvalidInput>(HasSubstr(text)); };
  const std::string good = "0 0 0 0 0 1 9 9 9";
  EXPECT_THAT(parse(ascii(good, "3 0 1 4")), says("a.ply: face 0: vertex 4, not one of the 4"));
  EXPECT_THAT(parse(ascii(good, "3 0 1 -1")), says("face 0: vertex -1"));
  EXPECT_THAT(parse(ascii(good, "3 0 1")), says("line 21, face 0: too few values in row 1 of 2"));
  EXPECT_THAT(parse(ascii(good, "256 0 1 2")), says("\"256\" is not a number, or not one of its"));
  EXPECT_THAT(parse(ascii("0 0 x 0 0 1 9 9 9", "3 0 1 2")), says("[not-finite]"));
  EXPECT_THAT(parse(ascii("0 nan 0 0 0 1 9 9 9", "3 0 1 2")), says("[not-finite]"));
  EXPECT_THAT(parse(ascii("0 1e99 0 0 0 1 9 9 9", "3 0 1 2")), says("[not-finite]"));
  EXPECT_THAT(parse("plx\n"), says("not a PLY file"));
  EXPECT_THAT(parse("ply\nformat ascii 2.0\n"), says("not one of the formats"));
  EXPECT_THAT(parse("ply\nformat ascii 1.0\nproperty int x\n"), says("before the first element"));
  EXPECT_THAT(parse("ply\nformat ascii 1.0\nelement vertex -1\n"), says("element NAME COUNT"));
  EXPECT_THAT(parse("ply\nformat ascii 1.0\nelement v 1\nproperty quad x\n"), says("\"quad\""));
  EXPECT_THAT(parse("ply\nformat ascii 1.0\nelement v 1\nend_header\n1\n"), says("[bad-header]"));
  EXPECT_THAT(parse("ply\nformat ascii 1.0\nend_header\n"), says("no element \"vertex\""));
}

TEST(ReadPly, AsksForNoMoreMemoryThanTheFileCouldHold) {
  const auto parse = [](const char* text) { return [text] { parse_mesh(text, "a.ply"); }; };
  EXPECT_THAT(parse("ply\nformat ascii 1.0\nelement vertex 999999999999\nproperty float x\n"
                    "end_header\n1 2 3\n"),
              ThrowsMessage<InvalidInput>(HasSubstr("999999999999 rows, but only 6 bytes")));
  EXPECT_THAT(parse("ply\nformat binary_little_endian 1.0\nelement face 1\n"
                    "property list uint double vertex_index\nend_header\n\xFF\xFF\xFF\xFF"),
              ThrowsMessage<InvalidInput>(HasSubstr("a list of 4294967295, but only 0 bytes")));
  EXPECT_THAT(parse("ply\nformat binary_little_endian 1.0\nelement face 1\n"
                    "property list char int vertex_index\nend_header\n\xFF"),
              ThrowsMessage<InvalidInput>(HasSubstr("a list of -1")));
}

TEST(ReadPly, CloudsHaveNoTriangles) {
  EXPECT_THAT(
      [] {
        parse_mesh(
            "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\n"
            "property float z\nend_header\n1 2 3\n",
            "a.ply");
      },
      ThrowsMessage<InvalidInput>(HasSubstr("a cloud of points? [no-triangles]")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh::readers
