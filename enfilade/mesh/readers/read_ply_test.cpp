#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <cmath>

#include "enfilade/mesh/read_mesh.h"

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

TEST(ReadPly, NormalsThatNobodyKnewAreLeftOut) {
  EXPECT_THAT(parse_mesh(ascii("0 0 0 0 0 0 1 1 1", "3 0 1 2"), "a.ply").mesh.normals, IsEmpty());
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
  EXPECT_THAT(parse(ascii(good, "3 0 1 2 3")), says("more values than properties"));
  EXPECT_THAT(parse(ascii(good, "256 0 1 2")), says("\"256\" is not a number, or not one of its"));
  EXPECT_THAT(parse(ascii("0 0 x 0 0 1 9 9 9", "3 0 1 2")), says("\"x\" is not a number"));
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
