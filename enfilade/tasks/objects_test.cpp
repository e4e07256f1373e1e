#include "enfilade/tasks/objects.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/tasks/formats/readers.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

using Box = std::array<std::int32_t, 4>;

const std::string kPot = R"({"name": "plant#pot", "visible_pos": [0, 35], )"
                         R"("bbox2d": [[494, 146, 146, 142], [0, -1, 0, 9]]})";
const std::string kDoor = R"({"name": "door", "visible_pos": [], "bbox2d": []})";
const std::string kObjects = R"({"97": )" + kPot + R"(, "8": )" + kDoor + "}";

std::string nested(const std::string& objects) { return R"({"s_v": {"v": )" + objects + "}}"; }

ObjectBoxes parse(const std::string& text) { return ObjectBoxes::parse(text, "b.json"); }

std::string faults_of(const std::string& text) {
  return tests::refusal<InvalidInput>([&] { parse(text); });
}

std::string edited(const std::string& from, const std::string& to) {
  std::string text = nested(kObjects);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

void expect_equal(const ObjectBoxes& a, const ObjectBoxes& b) {
  EXPECT_EQ(a.to_json(true), b.to_json(true));
}

TEST(ObjectBoxes, ReadsBothForms) {
  for (const std::string& text : {nested(kObjects), R"({"s_v": )" + kObjects + "}"}) {
    const ObjectBoxes boxes = parse(text);
    EXPECT_TRUE(boxes.has("s", "v"));
    EXPECT_FALSE(boxes.has("s", "w"));
    EXPECT_FALSE(boxes.has("t", "v"));
    const auto objects = boxes.at("s", "v");
    ASSERT_EQ(objects.size(), 2U);
    EXPECT_EQ(objects[0].id, 97) << "in the order of the file";
    EXPECT_EQ(objects[0].name, "plant#pot");
    EXPECT_THAT(objects[0].views, ElementsAre(0, 35));
    EXPECT_THAT(objects[0].boxes, ElementsAre(Box{494, 146, 146, 142}, Box{0, -1, 0, 9}));
    EXPECT_TRUE(objects[0].visible());
    EXPECT_EQ(objects[1].id, 8);
    EXPECT_EQ(objects[1].name, "door");
    EXPECT_FALSE(objects[1].visible());
    EXPECT_THAT(boxes.at("s", "w"), IsEmpty());
    EXPECT_THAT(boxes.at("t", "v"), IsEmpty());
  }
}

TEST(ObjectBoxes, AreSeenFromViewpointsInOrderOfIds) {
  ObjectBoxes boxes;
  EXPECT_TRUE(boxes.empty());
  boxes.add("s", "v9", {{7, "door", {3}, {{1, 2, 3, 4}}}});
  boxes.add("s", "v10", {{6, "sink", {1}, {{0, 0, 1, 1}}}, {7, "door", {0}, {{1, 2, 3, 4}}}});
  boxes.add("s", "v11", {{7, "door", {}, {}}});
  boxes.add("t", "v12", {{7, "lamp", {5}, {{1, 2, 3, 4}}}});
  boxes.add("t", "v13", {});
  EXPECT_FALSE(boxes.empty());
  EXPECT_THAT(boxes.seen_from("s", 7), ElementsAre("v10", "v9"));
  EXPECT_THAT(boxes.seen_from("s", 8), IsEmpty());
  EXPECT_THAT(boxes.seen_from("u", 7), IsEmpty());
  const ObjectBoxes::Counts counts = boxes.count();
  EXPECT_EQ(counts.viewpoints, 5U);
  EXPECT_EQ(counts.without_objects, 1U);
  EXPECT_EQ(counts.objects, 5U);
  EXPECT_EQ(counts.without_views, 1U);
  EXPECT_EQ(counts.boxes, 4U);
}

// Names of Matterport3D's category_mapping.tsv and of mpcat40, and of the model homes.
TEST(ObjectBoxes, PeopleAskForThingsAndNotForPartsOfTheBuilding) {
  for (const char* part : {"door frame",
                           "doorframe /otherroom",
                           "door frame#wooden",
                           "archway",
                           "arch",
                           "door",
                           "sliding door",
                           "garage door",
                           "window",
                           "window frame",
                           "window/door",
                           "skylight",
                           "wall",
                           "wall /otherroom",
                           "kitchen wall",
                           "wall_panel",
                           "floor",
                           "floor /outside",
                           "ceiling",
                           "ceiling_duct",
                           "Ceiling",
                           "roof",
                           "stairs",
                           "stair",
                           "step",
                           "staircase",
                           "beam",
                           "support beam",
                           "railing",
                           "balcony railing",
                           "banister",
                           "handrail",
                           "facade",
                           "molding",
                           "skirting board",
                           "landing",
                           "object",
                           "objects",
                           "unknown /otherroom",
                           "remove",
                           "void",
                           "misc",
                           "unlabeled",
                           "",
                           " ",
                           "#pot"}) {
    EXPECT_FALSE(can_be_asked_for(part)) << part;
  }
  for (const char* thing : {"chest_of_drawers",
                            "chest of drawers",
                            "plant#pot",
                            "coat",
                            "toilet",
                            "rug",
                            "doormat",
                            "bath mat",
                            "wall clock",
                            "wall lamp",
                            "floor lamp",
                            "ceiling fan",
                            "window shade",
                            "blinds",
                            "column",
                            "picture",
                            "picture frame",
                            "tv_monitor",
                            "door handle",
                            "stool",
                            "step stool",
                            "towel rail",
                            "fireplace",
                            "gym_equipment",
                            "fence",
                            "steamer"}) {
    EXPECT_TRUE(can_be_asked_for(thing)) << thing;
  }
  EXPECT_EQ(spoken_name("plant#pot"), "plant");
  EXPECT_EQ(spoken_name("wall /otherroom"), "wall");
  EXPECT_EQ(spoken_name("chest of drawers"), "chest of drawers");
}

TEST(ObjectBoxes, IdsOfOtherDataSetsHaveOtherLengths) {
  const ObjectBoxes boxes = parse(R"({"00000-kfPV7w3FaU5_000007": {}, "a_b_c": {}})");
  EXPECT_TRUE(boxes.has("00000-kfPV7w3FaU5", "000007"));
  EXPECT_TRUE(boxes.has("a_b", "c"));
}

// As cameras name their pictures: IMG_1_01.jpg.
TEST(ObjectBoxes, ViewpointsMayHaveUnderscores) {
  const std::string pot = R"({"7": )" + kPot + "}";
  for (const std::string& text :
       {R"({"home_IMG_1_01": {"IMG_1_01": )" + pot + "}}", R"({"home_IMG_1_01": )" + pot + "}"}) {
    const ObjectBoxes boxes = parse(text);
    EXPECT_EQ(boxes.at("home", "IMG_1_01").size(), 1U) << text;
    EXPECT_FALSE(boxes.has("home", "01"));
    EXPECT_FALSE(boxes.has("home", "IMG_1"));
    EXPECT_THAT(boxes.seen_from("home", 7), ElementsAre("IMG_1_01"));
  }
  ObjectBoxes boxes;
  boxes.add("my_home", "IMG_1_01", {});
  for (const bool form : {true, false}) {
    EXPECT_TRUE(parse(boxes.to_json(form)).has("my_home", "IMG_1_01"));
  }
}

// A viewpoint with the number of an object is told apart by what stands there.
TEST(ObjectBoxes, ViewpointsMayBeNumbers) {
  const ObjectBoxes expected = parse(R"({"s_12": {"12": {"12": )" + kPot + "}}}");
  ASSERT_EQ(expected.at("s", "12").size(), 1U);
  EXPECT_EQ(expected.at("s", "12")[0].id, 12);
  expect_equal(parse(R"({"s_12": {"12": )" + kPot + "}}"), expected);
  EXPECT_THAT(parse(R"({"s_12": {"12": {}}})").at("s", "12"), IsEmpty());
}

TEST(ObjectBoxes, ReadsWhatItWrites) {
  ObjectBoxes boxes;
  EXPECT_EQ(boxes.to_json(true), "{\n}\n");
  expect_equal(parse(boxes.to_json(true)), boxes);
  boxes.add("s_1", "12", {{9, "a \"q\"\\\n\xC3\xBC", {35, 0}, {{-2147483647 - 1, 0, 0, 7}, {}}}});
  boxes.add("s_1", "13", {});
  boxes.add("s", "1", {{1, "", {}, {}}, {0, "x", {}, {}}, {9223372036854775807, "y", {}, {}}});
  for (const bool form : {true, false}) {
    const ObjectBoxes read = parse(boxes.to_json(form));
    for (const auto& [scan, viewpoint] : {std::pair{"s_1", "12"}, {"s_1", "13"}, {"s", "1"}}) {
      const auto a = read.at(scan, viewpoint);
      const auto b = boxes.at(scan, viewpoint);
      EXPECT_TRUE(read.has(scan, viewpoint));
      EXPECT_TRUE(std::ranges::equal(a, b)) << scan << viewpoint;
    }
    EXPECT_EQ(read.to_json(form), boxes.to_json(form));
  }
  EXPECT_THAT(boxes.to_json(true), HasSubstr("\"s_1_13\":{\"13\":{}}"));
  EXPECT_THAT(boxes.to_json(false), HasSubstr("\"s_1_13\":{}"));
}

TEST(ObjectBoxes, NamesKeyPlaceAndWhatIsAllowed) {
  const std::string long_key(300, 'k');
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "the file is empty"},
      {"[]", "b.json: $: array of 0, not an object"},
      {nested(kObjects).substr(0, 60), "the file ends too early"},
      {std::string(3000, '['), "[not-json]"},
      {edited("494", "NaN"), "NaN and Infinity are not JSON"},
      {edited("494", "1e999"), "[not-json]"},
      {R"({"sv": {}})", "$.sv: not <scan>_<viewpoint>"},
      {R"({"_v": {}})", "$._v: an empty id"},
      {R"({"s_": {}})", "$.s_: an empty id"},
      {R"({"": {}})", "$[\"\"]: not <scan>_<viewpoint>"},
      {R"({"s_)" + long_key + R"(": {}})", "(300 bytes) is not an id"},
      {R"({"s_v": {}, "s_v": {}})", "$.s_v: given twice in one object"},
      {R"({"s_v": []})", "$.s_v: array of 0, not an object"},
      {R"({"s_v": {"v": []}})", "$.s_v.v: array of 0, not an object"},
      {R"({"s_v": {"v": {}, "v": {}}})", "$.s_v.v: given twice"},
      {R"({"s_9": {"9": )" + kDoor + R"(, "9": {}}})", "$.s_9.9: given twice"},
      {R"({"s_v": {"v": {}, "w": {}}})", "$.s_v.w: beside the viewpoint \"v\""},
      {R"({"s_v": {"w": {}}})", "$.s_v.w: neither the viewpoint \"v\" nor the number of an object"},
      {R"({"s_v": {"v": {"v": {}}}})", "$.s_v.v.v: neither the viewpoint"},
      {edited("\"97\"", "\"097\""), "$.s_v.v.097: neither"},
      {edited("\"97\"", "\"-97\""), "$.s_v.v[\"-97\"]: neither"},
      {edited("\"97\"", "\"-0\""), "$.s_v.v[\"-0\"]: neither"},
      {edited("\"97\"", "\"9.7\""), "$.s_v.v[\"9.7\"]: neither"},
      {edited("\"97\"", "\"9223372036854775808\""), "$.s_v.v.9223372036854775808: neither"},
      {edited("\"97\"", "\"8\""), "$.s_v.v.8: given twice"},
      {edited(kPot, "5"), "$.s_v.v.97: number 5, not an object"},
      {edited("\"name\"", "\"Name\""), "$.s_v.v.97: has no field \"name\""},
      {edited("\"plant#pot\"", "3"), "$.s_v.v.97.name: number 3, not a string"},
      {edited("\"visible_pos\"", "\"bbox2d\""), "$.s_v.v.97.bbox2d: given twice"},
      {edited("[0, 35]", "\"0\""), "$.s_v.v.97.visible_pos: string \"0\", not an array"},
      {edited("[0, 35]", "[0, 36]"), "$.s_v.v.97.visible_pos[1]: 36 is no view; 0 to 35 are"},
      {edited("[0, 35]", "[-1, 3]"), "$.s_v.v.97.visible_pos[0]: -1 is no view"},
      {edited("[0, 35]", "[0, 3.0]"), "$.s_v.v.97.visible_pos[1]: number 3, not a whole number"},
      {edited("[0, 35]", "[3, 3]"), "$.s_v.v.97.visible_pos[1]: view 3 stands there already"},
      {edited("[0, 35]", "[0]"), "$.s_v.v.97.bbox2d: 2 boxes, not 1, one for each view"},
      {edited("[494, 146, 146, 142], ", ""), "$.s_v.v.97.bbox2d: 1 boxes, not 2"},
      {edited("[494, 146, 146, 142], [0, -1, 0, 9]", "494, 146, 146, 142"),
       "$.s_v.v.97.bbox2d[0]: number 494, not an array"},
      {edited("[494, 146, 146, 142]", "[494, 146, 146]"),
       "$.s_v.v.97.bbox2d[0]: array of 3, not [x, y, width, height]"},
      {edited("494", "494, 1"), "$.s_v.v.97.bbox2d[0]: array of 5, not"},
      {edited("494", "null"), "$.s_v.v.97.bbox2d[0][0]: null, not a whole number"},
      {edited("142", "-1"), "$.s_v.v.97.bbox2d[0][3]: -1, not a size from 0 to 2147483647"},
      {edited("494", "2147483648"),
       "$.s_v.v.97.bbox2d[0][0]: 2147483648, not a place from -2147483648 to 2147483647"},
  };
  for (const auto& [text, expected] : cases) {
    EXPECT_THAT(faults_of(text), HasSubstr(expected)) << text.substr(0, 200);
  }
}

TEST(ObjectBoxes, AreReadOrRefusedWhateverByteChanges) {
  const std::string text = nested(kObjects);
  for (std::size_t at = 0; at < text.size(); ++at) {
    for (const char c : std::string_view("{}[],:\"\\09-.ex \xFF\0", 17)) {
      std::string changed = text;
      changed[at] = c;
      EXPECT_THAT(faults_of(changed), AnyOf("accepted", HasSubstr("b.json: $"))) << changed;
    }
  }
}

TEST(ObjectBoxes, ListsAllFaultsAtOnceAndStopsInTime) {
  EXPECT_THAT(faults_of(R"({"sv": 1, "s_v": {"3": {}, "x": 1}, "s_w": 2})"),
              AllOf(HasSubstr("$.sv:"), HasSubstr("$.s_v.3: has no field \"name\""),
                    HasSubstr("$.s_v.x:"), HasSubstr("$.s_w: number 2")));
  std::string many = "{";
  for (int k = 0; k < 5000; ++k) many += fmt::format("{}\"x{}\": 0", k == 0 ? "" : ",", k);
  for (const std::string& text : {many + "}", R"({"s_v":)" + many + "}}"}) {
    try {
      parse(text);
      ADD_FAILURE() << "accepted";
    } catch (const InvalidInput& error) {
      EXPECT_EQ(error.diagnostics().size(), kMostFaultsKept + 1);
      EXPECT_EQ(error.diagnostics().back().code, kMoreFaults);
    }
  }
}

TEST(ObjectBoxes, DoesNotTakeWhatItCouldNotRead) {
  ObjectBoxes boxes;
  boxes.add("s", "v", {});
  const auto refusal = [&](const std::string& scan, const std::string& viewpoint,
                           std::vector<ViewedObject> objects) {
    return tests::refusal<ArgumentError>([&] { boxes.add(scan, viewpoint, std::move(objects)); });
  };
  EXPECT_THAT(refusal("s", "v", {}), HasSubstr("viewpoint \"v\" of scan \"s\" is there already"));
  EXPECT_THAT(refusal("", "v", {}), HasSubstr("empty"));
  EXPECT_THAT(refusal("s", "", {}), HasSubstr("empty"));
  boxes.add("s", "v_1", {});
  EXPECT_THAT(refusal("s_v", "1", {}), HasSubstr("is there already"));
  EXPECT_THAT(refusal("s", std::string(300, 'v'), {}), HasSubstr("(300 bytes) is not an id"));
  EXPECT_THAT(refusal("s", "w", {{-1, "", {}, {}}}), HasSubstr("object -1 around viewpoint \"w\""));
  EXPECT_THAT(refusal("s", "w", {{1, "", {}, {}}, {1, "", {}, {}}}), HasSubstr("there twice"));
  EXPECT_THAT(refusal("s", "w", {{1, "", {0}, {}}}), HasSubstr("0 boxes for 1 views"));
  EXPECT_THAT(refusal("s", "w", {{1, "", {36}, {{}}}}), HasSubstr("view 36, not one from 0 to 35"));
  EXPECT_THAT(refusal("s", "w", {{1, "", {3, 3}, {{}, {}}}}), HasSubstr("view 3 twice"));
  EXPECT_THAT(refusal("s", "w", {{1, "", {3}, {{0, 0, -1, 5}}}}), HasSubstr("a box of -1 x 5"));
  EXPECT_FALSE(boxes.has("s", "w"));
  boxes.add("s", "w", {{1, "\xFF", {}, {}}});
  EXPECT_THROW(boxes.to_json(true), ArgumentError);
}

/// \name Files and folders
/// @{

class ObjectFiles : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    write_file_atomically(folder_.path() / name, text);
  }
  std::string load_faults() const {
    return tests::refusal<InvalidInput>([&] { ObjectBoxes::load(folder_.path()); });
  }

  tests::TemporaryFolder folder_{"objects"};
};

TEST_F(ObjectFiles, ArePackedOrPlain) {
  write("plain.json", nested(kObjects));
  write("packed.json.gz", gzip(nested(kObjects), 6));
  expect_equal(ObjectBoxes::load(folder_.path() / "plain.json"), parse(nested(kObjects)));
  expect_equal(ObjectBoxes::load(folder_.path() / "packed.json.gz"), parse(nested(kObjects)));
}

TEST_F(ObjectFiles, OfAFolderAreOneByViewpoint) {
  ObjectBoxes expected;
  for (int k = 0; k < 60; ++k) {
    const std::string viewpoint = fmt::format("v{}", k);
    const std::string content =
        fmt::format(R"({{"{}": {{"{}": {}}}}})", viewpoint, k, k % 2 == 0 ? kPot : kDoor);
    write(fmt::format("s_{}.json{}", viewpoint, k % 3 == 0 ? ".gz" : ""),
          k % 3 == 0 ? gzip(content, 6) : content);
    const ObjectBoxes one = parse(fmt::format("{{\"s_{}\": {}}}", viewpoint, content));
    const auto objects = one.at("s", viewpoint);
    expected.add("s", viewpoint, {objects.begin(), objects.end()});
  }
  write("s_none.json", R"({"none": {}})");
  write("s_bare.json", "{}");
  write("README.md", "Not JSON.");
  expected.add("s", "none", {});
  expected.add("s", "bare", {});
  expect_equal(ObjectBoxes::load(folder_.path()), expected);
}

TEST_F(ObjectFiles, OfAFolderNameTheirFaultsInOrder) {
  write("s_a.json", R"({"a": {"1": {}}})");
  write("s_b.json", R"({"b": {}})");
  write("s_b.json.gz", gzip(R"({"b": {}})", 6));
  write("s_c.json", R"({"b": {}})");
  write("s_d.json", R"({"d": )");
  write("se.json", R"({"e": {}})");
  std::vector<std::string> found;
  try {
    ObjectBoxes::load(folder_.path());
  } catch (const InvalidInput& error) {
    for (const Diagnostic& fault : error.diagnostics()) {
      const std::filesystem::path file(fault.file);
      EXPECT_EQ(file.parent_path(), folder_.path());
      found.push_back(fmt::format("{}: {} {}", file.filename().string(), fault.where, fault.code));
    }
  }
  EXPECT_THAT(found, ElementsAre("s_a.json: $.a.1 missing-field", "s_a.json: $.a.1 missing-field",
                                 "s_a.json: $.a.1 missing-field",
                                 "s_b.json.gz: $ repeated-viewpoint", "s_c.json: $.b bad-object-id",
                                 "s_d.json: $.d not-json", "se.json: $ bad-name"));
}

TEST_F(ObjectFiles, WithManyFaultsAreNotReadToTheEnd) {
  for (int k = 0; k < 1500; ++k) write(fmt::format("s_{}.json", k), "[]");
  try {
    ObjectBoxes::load(folder_.path());
    ADD_FAILURE() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.diagnostics().size(), kMostFaultsKept + 1);
    EXPECT_EQ(error.diagnostics().back().code, kMoreFaults);
    EXPECT_EQ(error.diagnostics().back().file, folder_.path().string());
  }
}

TEST_F(ObjectFiles, ThatAreNotThereOrDamagedAreNamed) {
  const auto refusal = [](const std::filesystem::path& path) {
    return tests::refusal<FileError>([&] { ObjectBoxes::load(path); });
  };
  EXPECT_THAT(refusal(folder_.path() / "none.json"), HasSubstr("none.json: cannot open"));
  EXPECT_THAT(refusal(folder_.path()), HasSubstr("has no file <scan>_<viewpoint>.json"));
  const std::string packed = gzip(R"({"v": {}})", 6);
  for (std::size_t bytes = 2; bytes < packed.size(); ++bytes) {
    write("s_v.json", packed.substr(0, bytes));
    EXPECT_THAT(refusal(folder_.path()), HasSubstr("s_v.json: cannot unpack")) << bytes;
  }
  make_folder(folder_.path() / "s_u.json");
  EXPECT_THAT(refusal(folder_.path()), HasSubstr("s_u.json: cannot read")) << "the first in order";
}
/// @}

/// \name Published boxes
/// @{

std::optional<std::filesystem::path> published() {
  const auto data = scan::DataRoot::from_environment();
  if (!data || !exists(data->folder() / "reverie" / "BBox.json.gz")) return std::nullopt;
  return data->folder() / "reverie";
}
constexpr const char* kNoBoxes = "ENFILADE_DATA is not set, or has no reverie/BBox.json.gz";

// Distinct (scan, viewpoint), with object names and (scan, object) that are visible.
struct Kinds {
  std::set<std::string> scans, names;
  std::set<std::pair<std::string, std::int64_t>> visible;
  std::size_t seeing = 0, most = 0;
};

// The viewpoints are those of the file's own keys, a line each.
Kinds kinds_of(const ObjectBoxes& boxes) {
  Kinds kinds;
  const std::string text = boxes.to_json(false);
  for (std::size_t at = text.find("\n\""); at != std::string::npos;
       at = text.find("\n\"", at + 1)) {
    const std::string key = text.substr(at + 2, text.find('"', at + 2) - at - 2);
    const std::string scan = key.substr(0, key.rfind('_'));
    const auto objects = boxes.at(scan, key.substr(key.rfind('_') + 1));
    kinds.scans.insert(scan);
    kinds.most = std::max(kinds.most, objects.size());
    bool sees = false;
    for (const ViewedObject& object : objects) {
      kinds.names.insert(object.name);
      if (object.visible()) kinds.visible.emplace(scan, object.id);
      sees = sees || object.visible();
    }
    if (sees) ++kinds.seeing;
  }
  return kinds;
}

TEST(ObjectBoxes, OfThePublishedFile) {
  const auto folder = published();
  if (!folder) GTEST_SKIP() << kNoBoxes;
  const ObjectBoxes boxes = ObjectBoxes::load(*folder / "BBox.json.gz");
  const ObjectBoxes::Counts counts = boxes.count();
  EXPECT_EQ(counts.viewpoints, 10'567U);
  EXPECT_EQ(counts.without_objects, 2385U);
  EXPECT_EQ(counts.objects, 38'293U);
  EXPECT_EQ(counts.without_views, 10'233U);
  EXPECT_EQ(counts.boxes, 210'198U);
  const Kinds kinds = kinds_of(boxes);
  EXPECT_EQ(kinds.scans.size(), 90U);
  EXPECT_EQ(kinds.seeing, 7009U);
  EXPECT_EQ(kinds.visible.size(), 17'289U);
  EXPECT_EQ(kinds.most, 61U);
  EXPECT_EQ(kinds.names.size(), 1325U);
  EXPECT_EQ(std::ranges::count_if(
                kinds.names, [](const auto& name) { return name.find('#') != std::string::npos; }),
            788);
  std::string written = boxes.to_json(true);
  std::erase(written, '\n');
  EXPECT_EQ(written, read_text_file(*folder / "BBox.json.gz")) << "but for line breaks the same";
  EXPECT_EQ(parse(boxes.to_json(false)).to_json(true), boxes.to_json(true));
}

// What the paths of a split find at their ends.
struct Ends {
  std::size_t unseen_at_end = 0, seen_at_start = 0, never_seen = 0;
};

Ends ends_of(const ObjectBoxes& boxes, const Annotations& annotations) {
  Ends ends;
  for (const PathAnnotation& entry : annotations.paths) {
    const auto seen = boxes.seen_from(entry.scan, std::get<NamedObject>(entry.goal).id);
    const auto from = [&](const std::string& viewpoint) {
      return std::ranges::binary_search(seen, viewpoint);
    };
    if (seen.empty()) ++ends.never_seen;
    if (!from(entry.path.back())) ++ends.unseen_at_end;
    if (from(entry.path.front())) ++ends.seen_at_start;
  }
  return ends;
}

TEST(ObjectBoxes, AreSeenAtTheEndsOfPublishedPaths) {
  const auto folder = published();
  if (!folder) GTEST_SKIP() << kNoBoxes;
  const ObjectBoxes boxes = ObjectBoxes::load(*folder / "BBox.json.gz");
  const auto ends = [&](const std::string& name) {
    return ends_of(boxes, formats::parse_reverie(read_text_file(*folder / name), name, "split"));
  };
  const Ends train = ends("v2/REVERIE_train.json");
  EXPECT_EQ(train.unseen_at_end, 33U);
  EXPECT_EQ(train.seen_at_start, 7U);
  EXPECT_EQ(ends("v2/REVERIE_val_seen.json").unseen_at_end, 3U);
  for (const char* name :
       {"v1/REVERIE_val_seen.json", "v1/REVERIE_val_unseen.json", "v2/REVERIE_val_unseen.json"}) {
    EXPECT_EQ(ends(name).unseen_at_end, 0U) << name;
    EXPECT_EQ(ends(name).never_seen, 0U) << name;
  }
}
/// @}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
