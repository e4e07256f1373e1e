#include "enfilade/mesh/segmentation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/mesh/mpcat40.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::mesh {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

/// A square and a triangle beside it, names as the documentation has them.
constexpr const char* kDocumented =
    "ply\nformat ascii 1.0\ncomment made by hand\nelement vertex 5\nproperty float x\n"
    "property float y\nproperty float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
    "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 2\n"
    "property list uchar int vertex_index\nproperty int face_material\n"
    "property int face_segment\nproperty int face_category\nend_header\n"
    "0 0 0 0 0 1 255 0 0\n2 0 0 0 0 1 0 255 0\n2 2 0 0 0 1 0 0 255\n0 2 0 0 0 1 0 0 0\n"
    "4 0 0 0 0 1 188 188 188\n4 0 1 2 3 7 70 700\n3 1 4 2 -1 -1 -1\n";

TEST(LabelledPly, ReadsDocumentedNamesAndPolygons) {
  const LabelledMesh m = parse_labelled_ply(kDocumented, "a.ply");
  ASSERT_EQ(m.mesh.triangles.size(), 3U);
  EXPECT_EQ(m.mesh.triangles[1], (std::array<std::uint32_t, 3>{0, 2, 3}));
  EXPECT_THAT(m.face, ElementsAre(0, 0, 1));
  EXPECT_EQ(m.faces, 2U);
  EXPECT_THAT(m.face_object, ElementsAre(7, 7, -1));
  EXPECT_THAT(m.face_segment, ElementsAre(70, 70, -1));
  EXPECT_THAT(m.face_category, ElementsAre(700, 700, -1));
  EXPECT_EQ(m.mesh.colours[0], (Vec3f{1, 0, 0}));
  // sRGB's 188 is half of full light to its own rounding: (188/255 + 0.055)^2.4 / 1.055^2.4.
  EXPECT_NEAR(m.mesh.colours[4].x, 0.5, 0.005);
}

TEST(LabelledPly, ReadsWhatItWrites) {
  LabelledMesh m = parse_labelled_ply(kDocumented, "a.ply");
  m.mesh.positions.resize(256 + 5, {1, 2, 3});
  for (std::size_t i = 0; i < 256; ++i) {  // each byte of sRGB comes back as itself
    m.mesh.colours.push_back(m.mesh.colours[0]);
  }
  m.face_object[2] = -2147483647;
  const std::string bytes = to_labelled_ply(m);
  EXPECT_THAT(bytes, HasSubstr("property int material_id\nproperty int segment_id\n"));
  const LabelledMesh back = parse_labelled_ply(bytes, "b.ply");
  EXPECT_EQ(back.mesh.positions, m.mesh.positions);
  EXPECT_EQ(back.mesh.triangles, m.mesh.triangles);
  EXPECT_EQ(back.mesh.colours, m.mesh.colours);
  EXPECT_EQ(back.face_object, m.face_object);
  EXPECT_EQ(back.face_segment, m.face_segment);
  EXPECT_EQ(back.face_category, m.face_category);
  EXPECT_THAT(back.face, ElementsAre(0, 1, 2));
  EXPECT_EQ(to_labelled_ply(back), bytes);
}

TEST(LabelledPly, SaysWhatIsMissing) {
  std::string text = kDocumented;
  text.replace(text.find("face_segment"), 12, "face_sediment");
  EXPECT_THAT([&] { parse_labelled_ply(text, "a.ply"); },
              ThrowsMessage<InvalidInput>(HasSubstr("no segment_id or face_segment")));
  text = kDocumented;
  text.replace(text.find("int face_category"), 3, "float");
  text.replace(text.find("70 700"), 6, "70 0.5");
  EXPECT_THAT([&] { parse_labelled_ply(text, "a.ply"); },
              ThrowsMessage<InvalidInput>(HasSubstr("face 0: face_category 0.5, not a whole")));
}

TEST(LabelledPly, WarnsOfOddValues) {
  EXPECT_TRUE(parse_labelled_ply(kDocumented, "a.ply").warnings.empty());
  std::string text = kDocumented;
  text.replace(text.find("property uchar red"), 18, "property float red");
  text.replace(text.find("255 0 0\n"), 8, "nan 0 0 9\n");
  text.insert(text.find("element vertex"), "by hand\n");
  const LabelledMesh m = parse_labelled_ply(text, "a.ply");
  std::vector<std::string> codes;
  for (const Diagnostic& d : m.warnings) codes.push_back(d.code);
  EXPECT_THAT(codes, ElementsAre("unknown-line", "long-row", "not-finite", "colour-bytes"));
  EXPECT_EQ(m.mesh.colours[0], (Vec3f{1, 1, 1}));
}

TEST(FaceSegments, ReadsNumbersAndTexts) {
  EXPECT_THAT(parse_face_segments(R"({"params": {}, "segIndices": [3, "4", -1]})", "f"),
              ElementsAre(3, 4, -1));
  const std::vector<std::int32_t> segments{1, 0, 2147483647, -1};
  EXPECT_EQ(parse_face_segments(face_segments_json(segments, "a\"b"), "f"), segments);
  const auto parse = [](const char* text) { return [text] { parse_face_segments(text, "f"); }; };
  EXPECT_THAT(parse("{}"), ThrowsMessage<InvalidInput>(HasSubstr("segIndices")));
  EXPECT_THAT(parse(R"({"segIndices": [1, 2.5]})"),
              ThrowsMessage<InvalidInput>(HasSubstr("$.segIndices[1]: number 2.5, not a whole")));
  EXPECT_THAT(parse(R"({"segIndices": ["x", -2, 4294967296]})"),
              ThrowsMessage<InvalidInput>(HasSubstr("$.segIndices[2]")));
}

TEST(SegmentGroups, ReadsEitherNameOfTheId) {
  const auto groups = parse_segment_groups(
      R"({"segGroups": [{"id": 0, "objectId": 9, "label": "sofa chair", "segments": [1, 2],
          "obb": {}}, {"objectId": 4, "label_index": 7, "segments": []}, {"segments": ["5"]}]})",
      "f");
  ASSERT_EQ(groups.size(), 3U);
  EXPECT_EQ(groups[0].id, 0);
  EXPECT_EQ(groups[0].label, "sofa chair");
  EXPECT_THAT(groups[0].segments, ElementsAre(1, 2));
  EXPECT_EQ(groups[1].id, 4);
  EXPECT_EQ(groups[1].label, "");
  EXPECT_EQ(groups[2].id, -1);
  EXPECT_THAT(groups[2].segments, ElementsAre(5));
  const auto back = parse_segment_groups(segment_groups_json(groups, "s"), "f");
  ASSERT_EQ(back.size(), 3U);
  EXPECT_EQ(back[0].label, "sofa chair");
  EXPECT_EQ(back[1].id, 4);
  EXPECT_EQ(back[2].segments, groups[2].segments);
  EXPECT_THAT([] { parse_segment_groups(R"({"segGroups": [{"label": 3, "segments": 1}]})", "f"); },
              ThrowsMessage<InvalidInput>(HasSubstr("$.segGroups[0].segments: number 1, not an")));
}

/// The folder of a building: two objects in the .house, one more in the .semseg.json.
class HouseMesh : public ::testing::Test {
 protected:
  HouseMesh() {
    write(".ply", kDocumented);
    write(".fsegs.json", R"({"segIndices": [70, 71]})");
    write(".semseg.json", R"({"segGroups": [{"id": 0, "label": "red rug", "segments": [70]},
                              {"id": 5, "label": "door", "segments": [71]}]})");
    write(".house",
          "ASCII 1.1\nH s - 0 0 0 0 2 2 2 1 0 1 0 0 0 0 0 0 0 0 1 1 1 0 0 0 0 0\n"
          "L 0 1 - 0 0 0 0 0 0 1 1 1 0 0 0 0 0\nR 0 0 0 0 b 0 0 0 0 0 0 1 1 1 2.5 0 0 0 0\n"
          "C 0 2 door 4 door 0 0 0 0 0\nC 1 3 floor#mat 2 floor 0 0 0 0 0\n"
          "O 0 0 0 0 0 0 1 0 0 0 1 0 1 1 1 0 0 0 0 0 0 0 0\n"
          "O 1 0 1 0 0 0 1 0 0 0 1 0 1 1 1 0 0 0 0 0 0 0 0\n"
          "E 0 1 70 1 0 0 0 0 0 0 1 1 1 0 0 0 0 0\nE 1 -1 71 1 0 0 0 0 0 0 1 1 1 0 0 0 0 0\n");
  }
  void write(const char* ending, std::string_view text) const {
    write_file_atomically(folder_ / (std::string("s") + ending), text);
  }
  void expect_refused(const char* says) const {
    EXPECT_THAT([this] { read_house_mesh(folder_, "s"); },
                ThrowsMessage<InvalidInput>(HasSubstr(says)));
  }
  const tests::TemporaryFolder made_{"house"};
  const std::filesystem::path& folder_ = made_.path();
};

TEST_F(HouseMesh, JoinsTheFourFiles) {
  const Mesh mesh = read_house_mesh(folder_, "s");
  EXPECT_THAT(mesh.triangle_object, ElementsAre(1, 1, 2));
  ASSERT_EQ(mesh.objects.size(), 3U);
  EXPECT_EQ(mesh.objects[0].name, "door");
  EXPECT_EQ(mesh.objects[0].category, Mpcat40::kDoor);
  EXPECT_EQ(mesh.objects[1].name, "red rug") << "the raw label, not \"floor mat\"";
  EXPECT_EQ(mesh.objects[1].category, Mpcat40::kFloor);
  EXPECT_EQ(mesh.objects[1].region, 0);
  EXPECT_EQ(mesh.objects[2].name, "door") << "of semseg alone; category as of its name in C";
  EXPECT_EQ(mesh.objects[2].category, Mpcat40::kDoor);
  EXPECT_EQ(mesh.objects[2].region, -1);
}

TEST_F(HouseMesh, TellsOddValuesOfThePly) {
  std::vector<Diagnostic> warnings;
  read_house_mesh(folder_, "s", &warnings);
  EXPECT_TRUE(warnings.empty());
  std::string text = kDocumented;
  write(".ply", text.insert(text.find("element vertex"), "by hand\n"));
  read_house_mesh(folder_, "s", &warnings);
  ASSERT_EQ(warnings.size(), 1U);
  EXPECT_EQ(warnings[0].code, "unknown-line");
}

TEST_F(HouseMesh, ReadsPackedFiles) {
  for (const char* ending : {"s.fsegs.json", "s.semseg.json"}) {
    const std::filesystem::path file = folder_ / ending;
    write_file_atomically(file.string() + ".gz", gzip(read_file(file), 6));
    std::filesystem::remove(file);
  }
  EXPECT_THAT(read_house_mesh(folder_, "s").triangle_object, ElementsAre(1, 1, 2));
  write(".fsegs.json.gz", gzip(R"({"segIndices": [70, 71, 72]})", 6));
  expect_refused("s.fsegs.json.gz: $.segIndices: segments of 3 faces");
}

TEST_F(HouseMesh, FacesWithoutASegmentHaveNoObject) {
  write(".fsegs.json", R"({"segIndices": [-1, 70]})");
  EXPECT_THAT(read_house_mesh(folder_, "s").triangle_object, ElementsAre(kNoObject, kNoObject, 1));
}

TEST_F(HouseMesh, RefusesFilesThatDisagree) {
  write(".fsegs.json", R"({"segIndices": [70, 71, 72]})");
  expect_refused("segments of 3 faces");
  write(".fsegs.json", R"({"segIndices": [70, 71]})");
  write(".semseg.json", R"({"segGroups": [{"segments": [70, 71]}, {"segments": [71]}]})");
  expect_refused("$.segGroups[1]: segment 71 is of object 1, but of 0 before");
  std::filesystem::remove(folder_ / "s.semseg.json");
  EXPECT_THROW(read_house_mesh(folder_, "s"), FileError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::mesh
