#include "enfilade/tasks/formats/readers.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "enfilade/core/gzip.h"
#include "enfilade/scan/data_root.h"
#include "tests/support/refusal.h"

namespace enfilade::tasks::formats {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::string kItem =
    R"({"id": "1357_66", "path": ["v0", "v1"], "objId": 66, "heading": 4.59, "scan": "square", )"
    R"("path_id": 1357, "instructions": ["Go.", "Wasch die T\u00fcr."]})";
const std::string kTest =
    R"({"id": "2021", "path": ["v0"], "heading": 0.5, "scan": "square", "instructions": ["Go."]})";

std::string edited(const std::string& item, const std::string& from, const std::string& to) {
  std::string text = "[" + item + "]";
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string faults_of(const std::string& text) {
  return tests::refusal<InvalidInput>([&] { parse_reverie(text, "r.json", "val"); });
}

TEST(Reverie, ReadsAnEntry) {
  const Annotations read = parse_reverie("[" + kItem + "]", "r.json", "val_seen");
  EXPECT_EQ(read.split, "val_seen");
  EXPECT_EQ(read.file, "r.json");
  EXPECT_EQ(read.task, Task::kReverie);
  ASSERT_EQ(read.paths.size(), 1U);
  const PathAnnotation& entry = read.paths[0];
  EXPECT_EQ(entry.id, "1357_66");
  EXPECT_EQ(entry.path_id, 1357);
  EXPECT_EQ(entry.goal, NamedGoal(NamedObject{66}));
  EXPECT_FALSE(entry.goal_hidden());
  EXPECT_EQ(entry.scan, "square");
  EXPECT_EQ(entry.heading, Radians(4.59));
  EXPECT_THAT(entry.path, ElementsAre("v0", "v1"));
  EXPECT_THAT(entry.instructions, ElementsAre("Go.", "Wasch die T\xC3\xBCr."));
  EXPECT_EQ(entry.distance, std::nullopt);
  EXPECT_EQ(entry.group, 1357);
  EXPECT_THAT(entry.details, IsEmpty());
}

TEST(Reverie, OfTestEntriesTheIdIsThePath) {
  for (const std::string& text : {kTest, edited(kTest, "\"id\"", "\"path_id\": 2021, \"id\"")}) {
    const Annotations read = parse_reverie(text, "r.json", "test");
    ASSERT_EQ(read.paths.size(), 1U);
    EXPECT_EQ(read.paths[0].id, "2021");
    EXPECT_EQ(read.paths[0].path_id, 2021);
    EXPECT_EQ(read.paths[0].goal, NamedGoal(HiddenGoal{}));
    EXPECT_TRUE(read.paths[0].goal_hidden());
    EXPECT_THAT(read.paths[0].path, ElementsAre("v0"));
  }
}

TEST(Reverie, ReadsOverWhatVersion1HasBeside) {
  const std::string old = edited(kItem, "\"objId\"",
                                 "\"distance\": 11.65, \"ix\": 208, \"instructions_l\": [\"Walk "
                                 "out.\"], \"objId\"");
  EXPECT_EQ(parse_reverie(old, "", "val").paths, parse_reverie("[" + kItem + "]", "", "val").paths);
}

TEST(Reverie, ReadsTokensOfAListOrLines) {
  const std::string item =
      kItem.substr(0, kItem.size() - 1) + R"(, "instr_encodings": [[101, 2175, 102], []]})";
  for (const std::string& text : {"[" + item + ", " + kTest + "]", item + "\n\n" + kTest + "\n"}) {
    const Annotations read = parse_reverie(text, "r.json", "train");
    ASSERT_EQ(read.paths.size(), 2U);
    ASSERT_EQ(read.paths[0].details.size(), 2U);
    EXPECT_THAT(read.paths[0].details[0].tokens, ElementsAre(101, 2175, 102));
    EXPECT_THAT(read.paths[0].details[1].tokens, IsEmpty());
    EXPECT_EQ(read.paths[0].details[0].id, "");
    EXPECT_EQ(read.paths[0].goal, NamedGoal(NamedObject{66}));
    EXPECT_THAT(read.paths[1].details, IsEmpty());
  }
}

TEST(Reverie, TakesListsWithoutPathsOrInstructions) {
  EXPECT_THAT(parse_reverie("[]", "r.json", "val").paths, IsEmpty());
  const std::string waiting = edited(kTest, "[\"Go.\"]", "[]");
  EXPECT_THAT(parse_reverie(waiting, "", "val").paths.at(0).instructions, IsEmpty());
}

TEST(Reverie, GoalsOfATestSplitMayHaveItsNumbers) {
  const Annotations goals = parse_reverie(edited(kItem, "1357_66", "2021"), "goals.json", "test");
  EXPECT_EQ(parse_reverie(to_reverie(goals), "goals.json", "test").paths, goals.paths);
  const PathAnnotation& read = goals.paths.at(0);
  EXPECT_EQ(read.id, "2021");
  EXPECT_EQ(read.path_id, 1357);
  EXPECT_EQ(read.goal, NamedGoal(NamedObject{66}));
  EXPECT_FALSE(read.goal_hidden());
}

TEST(Reverie, NamesFieldPlaceAndWhatIsAllowed) {
  const std::string encoded =
      kItem.substr(0, kItem.size() - 1) + R"(, "instr_encodings": [[101]]})";
  const std::string deep(3000, '[');
  const std::vector<std::pair<std::string, std::string>> cases{
      {"3", "$[0]: number 3, not an object"},
      {"{}", "$[0]: has no field \"id\""},
      {"[" + kItem + ", 7]", "$[1]: number 7, not an object"},
      {"[" + kItem + ", ", "the file ends too early"},
      {deep, "[not-json]"},
      {edited(kItem, "4.59", "NaN"), "NaN and Infinity are not JSON"},
      {edited(kItem, "4.59", "1e999"), "[not-json]"},
      {edited(kItem, "4.59", "null"), "$[0].heading: null, not a number"},
      {edited(kItem, "\"id\": \"1357_66\"", "\"id\": 1357"), "$[0].id: number 1357, not a string"},
      {edited(kItem, "1357_66", "1357_67"), R"($[0].id: "1357_67", not "1357_66", its path_id)"},
      {edited(kItem, "1357_66", "07"), R"($[0].id: "07", not "1357_66")"},
      {edited(kItem, "1357_66", "01357_66"), R"($[0].id: "01357_66", not "1357_66")"},
      {edited(kItem, "1357_66", ""), "$[0].id: an empty id"},
      {edited(kItem, "\"path_id\": 1357", "\"path_id\": \"1357\""),
       "$[0].path_id: string \"1357\", not a whole number"},
      {edited(kItem, "\"path_id\": 1357", "\"path_id\": -1"), "$[0].path_id: -1 is no id; 0"},
      {edited(kItem, "\"path_id\": 1357, ", ""), "$[0]: has \"objId\", but no field \"path_id\""},
      {edited(kItem, "\"path_id\": 1357", "\"path_id\": 99999999999999999999"), "[not-json]"},
      {edited(kItem, "\"path_id\": 1357", "\"path_id\": 10000000000000000000"),
       "$[0].path_id: number 10000000000000000000, not a whole number"},
      {edited(kItem, "\"objId\": 66", "\"objId\": \"66\""), "$[0].objId: string \"66\", not"},
      {edited(kItem, "\"objId\": 66", "\"objId\": 66.0"), "$[0].objId: number 66, not a whole"},
      {edited(kItem, "\"objId\": 66", "\"objId\": null"), "$[0].objId: null, not a whole"},
      {edited(kItem, "\"objId\": 66", "\"objId\": -66"), "$[0].objId: -66 is no id"},
      {edited(kItem, "\"objId\": 66", "\"objid\": 66"),
       "$[0].id: \"1357_66\", not the number of a path, as there is no \"objId\""},
      {edited(kItem, "\"objId\": 66", "\"objId\": 66, \"objId\": 66"),
       "$[0].objId: given twice in one object"},
      {edited(kItem, "[\"v0\", \"v1\"]", "[]"), "$[0].path: no viewpoint; the start"},
      {edited(kItem, "[\"v0\", \"v1\"]", "\"v0\""), "$[0].path: string \"v0\", not an array"},
      {edited(kItem, "[\"v0\", \"v1\"]", "[[\"v0\"]]"), "$[0].path[0]: array of 1, not a string"},
      {edited(kItem, "\"Go.\"", "5"), "$[0].instructions[0]: number 5, not a string"},
      {edited(kItem, "\"instructions\"", "\"instruction\""), "$[0]: has no field \"instructions\""},
      {"[" + encoded + "]", "$[0].instr_encodings: 1 lists of tokens; 2 are expected"},
      {edited(encoded, "[101]", "[101], [-1]"), "$[0].instr_encodings[1][0]: -1 is no token id"},
      {edited(encoded, "[101]", "[101], 102"), "$[0].instr_encodings[1]: number 102, not an array"},
      {edited(kTest, "2021", "2021_3"), "$[0].id: \"2021_3\", not the number of a path"},
      {edited(kTest, "2021", "01"), "$[0].id: \"01\", not the number of a path"},
      {edited(kTest, "2021", "007"), "$[0].id: \"007\", not the number of a path"},
      {edited(kTest, "\"id\"", "\"path_id\": 3, \"id\""), "$[0].path_id: 3, not 2021, its id"},
      {edited(kTest, "[\"v0\"]", "[\"v0\", \"v1\"]"), "$[0].path: 2 viewpoints, not the start"},
      {"[" + kItem + "," + kTest + "," + kItem + "]",
       "$[2].id: \"1357_66\" stands at $[0] already"},
      {kTest + "\n" + kTest, "$[1].id: \"2021\" stands at $[0] already"},
      {kTest + "\n{\"id\"", "r.json:2: $"},
  };
  for (const auto& [text, expected] : cases) {
    EXPECT_THAT(faults_of(text), HasSubstr(expected)) << text.substr(0, 200);
  }
}

TEST(Reverie, IsReadOrRefusedWhateverByteChanges) {
  const std::string text = "[" + kItem + ",\n" + kTest + "]";
  for (std::size_t at = 0; at < text.size(); ++at) {
    for (const char c : std::string_view("{}[],:\"\\09-.ex \xFF\0", 17)) {
      std::string changed = text;
      changed[at] = c;
      EXPECT_THAT(faults_of(changed), AnyOf("accepted", HasSubstr("r.json:"))) << changed;
    }
  }
}

TEST(Reverie, ReadsWhatItWrites) {
  std::string tokens = edited(kItem, "1357_66", "1357_67");
  tokens = tokens.substr(1, tokens.size() - 2);
  tokens = edited(tokens, "\"objId\": 66", "\"instr_encodings\": [[101, 7], []], \"objId\": 67");
  const Annotations read =
      parse_reverie("[" + kItem + ", " + kTest + ", " + tokens.substr(1), "r.json", "val");
  ASSERT_EQ(read.paths.size(), 3U);
  const std::string written = to_reverie(read);
  EXPECT_EQ(std::ranges::count(written, '\n'), 5);
  EXPECT_EQ(parse_reverie(written, "r.json", "val").paths, read.paths);
}

TEST(Reverie, DoesNotWriteWhatItCouldNotRead) {
  const auto refusal_of = [](const auto& change) {
    Annotations annotations = parse_reverie("[" + kItem + "]", "r.json", "val");
    change(annotations.paths[0]);
    return tests::refusal<ArgumentError>([&] { to_reverie(annotations); });
  };
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.goal = NearEnd{}; }),
              HasSubstr("entry \"1357_66\": its goal is neither hidden nor an object"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.goal = HiddenGoal{}; }),
              HasSubstr("its id has to be \"1357\""));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.goal = NamedObject{-1}; }),
              HasSubstr("a negative id"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.path.clear(); }),
              HasSubstr("a path of 0 viewpoints"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.details.resize(1); }),
              HasSubstr("2 instructions with details of 1"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.heading = Radians(1 / 0.0); }),
              HasSubstr("not finite"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.instructions[0] = "\xFF"; }),
              HasSubstr("not UTF-8"));
}

TEST(Reverie, ListsAllFaultsAtOnce) {
  const std::string all = faults_of(R"([{"id": "1_2"}, 2, {"id": 3, "path": [4], "heading": "5",
      "scan": null, "instructions": {}, "objId": true, "path_id": []}])");
  EXPECT_THAT(all, AllOf(HasSubstr("$[0]: has no field \"scan\""), HasSubstr("$[1]: number 2"),
                         HasSubstr("$[2].id: number 3"), HasSubstr("$[2].path[0]: number 4"),
                         HasSubstr("$[2].heading: string \"5\"")));
  std::string many = "[0";
  for (int k = 0; k < 5000; ++k) many += ",0";
  try {
    parse_reverie(many + "]", "r.json", "val");
    ADD_FAILURE() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.diagnostics().size(), kMostFaultsKept + 1);
    EXPECT_EQ(error.diagnostics().back().code, kMoreFaults);
  }
}

/// \name Published files
/// @{

// The text of a published file; empty if the data set is not there.
std::string published(const std::string& name) {
  const auto data = scan::DataRoot::from_environment();
  if (!data || !exists(data->folder() / "reverie" / name)) return {};
  return read_text_file(data->folder() / "reverie" / name);
}

struct Sizes {
  std::size_t items = 0, instructions = 0, scans = 0, viewpoints = 0, nodes = 0, characters = 0;
  std::size_t goals = 0, longest_path = 0;  // goals: different objects of scans
  friend bool operator==(const Sizes&, const Sizes&) = default;
};

// NOLINTNEXTLINE(readability-identifier-naming): GoogleTest looks for this name.
void PrintTo(const Sizes& s, std::ostream* out) {
  *out << fmt::format(
      "{} items, {} instructions, {} scans, {} viewpoints, {} nodes, {} characters, "
      "{} goals, at most {} nodes",
      s.items, s.instructions, s.scans, s.viewpoints, s.nodes, s.characters, s.goals,
      s.longest_path);
}

std::size_t characters(const std::string& text) {  // code points
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

Sizes sizes_of(const Annotations& annotations) {
  std::set<std::string> scans;
  std::set<std::pair<std::string, std::string>> viewpoints;
  std::set<std::pair<std::string, std::int64_t>> goals;
  Sizes sizes;
  sizes.items = annotations.paths.size();
  for (const PathAnnotation& entry : annotations.paths) {
    scans.insert(entry.scan);
    sizes.nodes += entry.path.size();
    sizes.longest_path = std::max(sizes.longest_path, entry.path.size());
    for (const std::string& viewpoint : entry.path) viewpoints.emplace(entry.scan, viewpoint);
    sizes.instructions += entry.instructions.size();
    for (const std::string& text : entry.instructions) sizes.characters += characters(text);
    if (const auto* object = std::get_if<NamedObject>(&entry.goal)) {
      goals.emplace(entry.scan, object->id);
    }
  }
  sizes.scans = scans.size();
  sizes.viewpoints = viewpoints.size();
  sizes.goals = goals.size();
  return sizes;
}

TEST(Reverie, OfPublishedFiles) {
  if (published("v2/REVERIE_val_seen.json").empty()) {
    GTEST_SKIP() << "ENFILADE_DATA is not set, or has no folder reverie: no published annotations";
  }
  const std::map<std::string, Sizes> expected{
      {"v1/REVERIE_val_seen.json", {515, 1423, 46, 641, 3194, 118'978, 440, 7}},
      {"v1/REVERIE_val_unseen.json", {1328, 3521, 10, 536, 7900, 317'809, 513, 7}},
      {"v1/REVERIE_test.json", {2304, 6292, 16, 401, 2304, 557'417, 0, 1}},
      {"v2/REVERIE_train.json", {4071, 10'290, 60, 3478, 24'638, 935'880, 2304, 10}},
      {"v2/REVERIE_val_seen.json", {501, 1384, 46, 650, 3122, 115'590, 428, 8}},
      {"v2/REVERIE_val_unseen.json", {1292, 3433, 10, 536, 7702, 308'041, 502, 8}},
      {"v2/REVERIE_test.json", {2244, 6144, 16, 396, 2244, 543'461, 0, 1}},
  };
  for (const auto& [name, sizes] : expected) {
    const Annotations read = parse_reverie(published(name), name, "split");
    EXPECT_EQ(sizes_of(read), sizes) << name;
    EXPECT_TRUE(parse_reverie(to_reverie(read), name, "split").paths == read.paths) << name;
    for (const PathAnnotation& entry : read.paths) {
      EXPECT_EQ(entry.goal_hidden(), name.ends_with("test.json"));
      EXPECT_GE(entry.heading.value, 0);
      EXPECT_LT(entry.heading.value, 2 * kPi);
      EXPECT_THAT(entry.instructions.size(), AllOf(::testing::Ge(1U), ::testing::Le(9U)));
    }
  }
}

TEST(Reverie, OfAPublishedFileThatIsCut) {
  const std::string text = published("v2/REVERIE_val_seen.json");
  if (text.empty()) {
    GTEST_SKIP() << "ENFILADE_DATA is not set, or has no folder reverie: no published annotations";
  }
  for (std::size_t part = 1; part < 40; ++part) {
    EXPECT_THAT(faults_of(text.substr(0, text.size() * part / 40)), HasSubstr("r.json: $")) << part;
  }
}
/// @}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks::formats
