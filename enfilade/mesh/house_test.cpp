#include "enfilade/mesh/house.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>

#include "enfilade/core/errors.h"

namespace enfilade::mesh {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// Written by hand after the layout of Matterport3D's data_organization.md: one record a kind.
constexpr const char* kLines[] = {
    "ASCII 1.1",
    "H  17DRP5sb8fy -  1 1 2 1 2 1 2  1 1 1  0 0 0 0 0  -1 -2 -3  4 5 6  0 0 0 0 0",
    "L 0 1 -  1 2 3  -1 -2 -3 4 5 6  0 0 0 0 0",
    "R 0 0 0 0 b  1.5 2.5 0  -1 -2 0 4 5 2.7  2.75 0 0 0 0",
    "P 0 0 -1 door  1 0 0  2 0 2.1  0 0 0 0",
    "S 0 0 0 F  1 1 0  0 0 1  -1 -2 0 4 5 0  0 0 0 0 0",
    "V 0 0 -  0 0 0  0 0 1  0 0 0",
    "V 1 0 corner  4.25 0 0  0 0 1  0 0 0",
    "P 00ebbf3782c64d74aaf7dd39cd561175 0 0 0  1.25 -2e-1 1.5  0 0 0 0 0",
    ("I 0 0 00ebbf3782c64d74aaf7dd39cd561175 2 5  1 0 0 -1  0 1 0 -2  0 0 1 -3  0 0 0 1  "
     "1075.5 0 629.75  0 1075.25 522.25  0 0 1  1280 1024  1 2 3  0 0 0 0 0"),
    "C 0 28 door#frame 4 door  0 0 0 0 0",
    "C 1 -1 - 0 void  0 0 0 0 0",
    "O 0 0 1  1 2 3  1 0 0  0 1 0  0.5 0.25 0.125  0 0 0 0 0 0 0 0",
    "E 0 0 77 0.5  1 2 3  0 0 0 1 1 1  0 0 0 0 0",
    "E 1 -1 78 0  1 2 3  0 0 0 1 1 1  0 0 0 0 0",
};
constexpr std::size_t kLineCount = std::size(kLines);

/// The lines above with one of them (numbered from 1) replaced.
std::string text_with(std::size_t line = 0, const std::string& replacement = "") {
  std::string out;
  for (std::size_t i = 0; i < kLineCount; ++i) {
    out += (i + 1 == line ? replacement : std::string(kLines[i])) + "\n";
  }
  return out;
}

TEST(House, ReadsEachRecord) {
  const House h = parse_house(text_with(), "a.house");
  EXPECT_EQ(h.name, "17DRP5sb8fy");
  EXPECT_EQ(h.label, "");
  EXPECT_EQ(h.box.low, (Vec3d{-1, -2, -3}));
  EXPECT_EQ(h.box.high, (Vec3d{4, 5, 6}));
  ASSERT_EQ(h.levels.size(), 1U);
  EXPECT_EQ(h.levels[0].position, (Vec3d{1, 2, 3}));
  ASSERT_EQ(h.regions.size(), 1U);
  EXPECT_EQ(h.regions[0].label, 'b');
  EXPECT_EQ(h.regions[0].position, (Vec3d{1.5, 2.5, 0}));
  EXPECT_EQ(h.regions[0].height, 2.75);
  ASSERT_EQ(h.portals.size(), 1U);
  EXPECT_EQ(h.portals[0].region1, -1);
  EXPECT_EQ(h.portals[0].label, "door");
  EXPECT_EQ(h.portals[0].p1, (Vec3d{2, 0, 2.1}));
  ASSERT_EQ(h.surfaces.size(), 1U);
  EXPECT_EQ(h.surfaces[0].normal, (Vec3d{0, 0, 1}));
  ASSERT_EQ(h.vertices.size(), 2U);
  EXPECT_EQ(h.vertices[1].position, (Vec3d{4.25, 0, 0}));
  EXPECT_EQ(h.vertices[1].label, "corner");
  ASSERT_EQ(h.panoramas.size(), 1U);
  EXPECT_EQ(h.panoramas[0].name, "00ebbf3782c64d74aaf7dd39cd561175");
  EXPECT_EQ(h.panoramas[0].position, (Vec3d{1.25, -0.2, 1.5}));
  ASSERT_EQ(h.images.size(), 1U);
  EXPECT_EQ(h.images[0].camera, 2);
  EXPECT_EQ(h.images[0].yaw, 5);
  EXPECT_EQ(h.images[0].camera_from_world[11], -3);
  EXPECT_EQ(h.images[0].intrinsics[4], 1075.25);
  EXPECT_EQ(h.images[0].width, 1280U);
  EXPECT_EQ(h.images[0].height, 1024U);
  EXPECT_EQ(h.images[0].position, (Vec3d{1, 2, 3}));
  ASSERT_EQ(h.categories.size(), 2U);
  EXPECT_EQ(h.categories[0].mapping_index, 28);
  EXPECT_EQ(h.categories[0].mapping_name, "door frame");
  EXPECT_EQ(h.categories[0].mpcat40_index, 4);
  EXPECT_EQ(h.categories[1].mapping_name, "");
  ASSERT_EQ(h.objects.size(), 1U);
  EXPECT_EQ(h.objects[0].category, 1);
  EXPECT_EQ(h.objects[0].radii, (Vec3d{0.5, 0.25, 0.125}));
  ASSERT_EQ(h.segments.size(), 2U);
  EXPECT_EQ(h.segments[0].id, 77);
  EXPECT_EQ(h.segments[1].object, -1);
}

TEST(House, TextReadsBackEqual) {
  House h = parse_house(text_with(), "a.house");
  h.name = "the old mill";
  h.categories[0].mapping_name = "tab\tnew\nline";
  h.regions[0].position.x = 0.1 + 0.2;
  const std::string text = to_text(h);
  const House back = parse_house(text, "b.house");
  EXPECT_EQ(back.name, "the old mill");
  EXPECT_EQ(back.categories[0].mapping_name, "tab new line");
  EXPECT_EQ(back.regions[0].position.x, 0.1 + 0.2);
  EXPECT_EQ(to_text(back), text);
  EXPECT_EQ(back.images[0].intrinsics, h.images[0].intrinsics);
  EXPECT_EQ(back.vertices[0].label, "");
}

TEST(House, TextHasTheDocumentedLengths) {
  const std::string text = to_text(parse_house(text_with(), "a.house"));
  const std::size_t expected[] = {2, 29, 18, 20, 15, 22, 13, 13, 13, 41, 11, 11, 24, 19, 19};
  std::size_t line = 0;
  for (std::size_t at = 0; at < text.size(); ++line) {
    const std::size_t end = text.find('\n', at);
    const auto blanks = std::count(text.begin() + static_cast<std::ptrdiff_t>(at),
                                   text.begin() + static_cast<std::ptrdiff_t>(end), ' ');
    ASSERT_LT(line, std::size(expected));
    EXPECT_EQ(static_cast<std::size_t>(blanks) + 1, expected[line]) << "line " << line + 1;
    at = end + 1;
  }
  EXPECT_EQ(line, std::size(expected));
}

TEST(House, ReadsTheOldHeaderAndOddVersions) {
  const House old = parse_house(
      "ASCII 1.0\r\nH a b 0 0 0 0 0 1  0 0 0 1 1 1  0 0 0 0 0 0 0 0\r\n\r\n"
      "L 0 0 -  1 2 3  -1 -2 -3 4 5 6  0 0 0 0 0\r\n",
      "f");
  EXPECT_EQ(old.label, "b");
  EXPECT_EQ(old.levels.size(), 1U);
  EXPECT_EQ(parse_house(text_with(1, "ASCII 1."), "f").segments.size(), 2U);
}

TEST(House, NamesLineAndField) {
  const auto faulty = [](std::size_t line, const std::string& text) {
    return [=] { parse_house(text_with(line, text), "a.house"); };
  };
  const auto says = [](const char* text) { return ThrowsMessage<InvalidInput>(HasSubstr(text)); };
  EXPECT_THAT([] { parse_house("", "a.house"); }, says("line 1: \"\", not \"ASCII 1.0\""));
  EXPECT_THAT(faulty(1, "ASCII 2.0"), says("not \"ASCII 1.0\""));
  EXPECT_THAT(faulty(2, "H a b 1"), says("line 2: a record \"H\" of 4 words, not an H record"));
  EXPECT_THAT(faulty(4, "R 0 0 0 0 b"), says("a.house: line 4: a record R (regions) of 6 words"));
  EXPECT_THAT(faulty(4, "R 0 1 0 0 b 1 2 0 0 0 0 1 1 1 2 0 0 0 0"), says("level 1, not -1 or"));
  EXPECT_THAT(faulty(4, "R 3 0 0 0 b 1 2 0 0 0 0 1 1 1 2 0 0 0 0"), says("index 3, not its"));
  EXPECT_THAT(faulty(4, "R 0 0 0 0 bed 1 2 0 0 0 0 1 1 1 2 0 0 0 0"), says("label \"bed\""));
  EXPECT_THAT(faulty(4, "R 0 0 0 0 b nan 2 0 0 0 0 1 1 1 2 0 0 0 0"), says("position \"nan\""));
  EXPECT_THAT(faulty(4, "R 0 0 0 0 b 1 2 0 0 0 0 1 1 1 1e999 0 0 0 0"), says("height \"1e999\""));
  EXPECT_THAT(faulty(14, "E 0 0 5000000000 0 1 2 3 0 0 0 1 1 1 0 0 0 0 0"), says("id \"5000"));
  EXPECT_THAT(faulty(14, ""), says("line 15: index 1, not its place"));
  EXPECT_THAT(faulty(14, ""), says("the end after 1 segments, but H says 2"));
  EXPECT_THAT(faulty(7, ""), says("a record \"P\" after 1 vertices, but H says 2"));
  EXPECT_THAT(faulty(3, "X"), says("line 3: a record \"X\" after 0 levels, but H says 1"));
  EXPECT_THAT([] { parse_house(text_with() + "E 2\n", "f"); }, says("after all that H says"));
}

TEST(House, ReportsManyFaultsAtOnce) {
  std::string text = text_with(13, "O 0 7 1  1 2 3  1 0 x  0 1 0  0.5 y 0.125  0 0 0 0 0 0 0 0");
  try {
    parse_house(text, "a.house");
    FAIL();
  } catch (const InvalidInput& e) {
    ASSERT_EQ(e.diagnostics().size(), 3U);
    EXPECT_EQ(e.diagnostics()[0].where, "line 13");
    EXPECT_EQ(e.diagnostics()[0].code, "bad-index");
    EXPECT_EQ(e.diagnostics()[1].code, "bad-value");
  }
}

TEST(House, CutAnywhereIsRefused) {
  const std::string text = text_with();
  // The last line's last number may lose its digits but not itself.
  for (std::size_t size = 0; size + 2 < text.size(); ++size) {
    EXPECT_THROW(parse_house(std::string_view(text).substr(0, size), "f"), InvalidInput) << size;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh
