#include "enfilade/tasks/formats/readers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/core/utf8.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/tasks/formats/records.h"
#include "tests/support/recorded_annotations.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tasks::formats {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kEncoded = R"([
 {"distance": 11.65, "scan": "VLzqgDo317F", "path_id": 4332, "path": ["v0", "v1", "v2"],
  "heading": 4.055, "instructions": ["Exit the bedroom. ", "Straße."],
  "instr_encodings": [[101, 6164, 102], [101, 102]]},
 {"scan": "pa4otMbVnkk", "path_id": 8, "path": ["v3"], "heading": 0, "instructions": ["Go."],
  "instr_encodings": [[101, 2147483647, 102]]}])";

constexpr const char* kLines =
    R"({"instr_id": "4332_0", "scan": "s", "path": ["v0", "v1"], "heading": 4.055, "instr_encoding": [101, 102]}
{"instr_id": "4332_1", "scan": "s", "path": ["v0", "v1"], "instr_encoding": []}

{"instr_id": "7_0", "scan": "t", "path": ["v2"], "heading": 1, "instr_encoding": [0]})";

constexpr const char* kBack = R"([
 {"distance": 4.5, "scan": "s", "path_id": 1, "path": ["v0", "v1", "v0"], "heading": 1.5,
  "instructions": ["There and back."], "midstop": "v1"},
 {"scan": "s", "path_id": 2, "path": ["v0"], "heading": 0, "instructions": ["Again."]}])";

std::string edited(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

Annotations parse(const std::string& text, Task task = Task::kR2r) {
  return parse_r2r_family(text, "r.json", "val", task);
}

std::string faults_of(const std::string& text, Task task = Task::kR2r) {
  return tests::refusal<InvalidInput>([&] { parse(text, task); });
}

// What is read, written and read again.
std::vector<PathAnnotation> again(const Annotations& annotations) {
  return parse(to_r2r_family(annotations), annotations.task).paths;
}

TEST(R2rFamily, HasTokensByInstruction) {
  const Annotations read = parse(kEncoded);
  EXPECT_EQ(read.split, "val");
  EXPECT_EQ(read.file, "r.json");
  EXPECT_EQ(read.task, Task::kR2r);
  ASSERT_EQ(read.paths.size(), 2U);
  const PathAnnotation& path = read.paths[0];
  EXPECT_EQ(path.path_id, 4332);
  EXPECT_EQ(path.scan, "VLzqgDo317F");
  EXPECT_EQ(path.heading, Radians(4.055));
  EXPECT_THAT(path.path, ElementsAre("v0", "v1", "v2"));
  EXPECT_EQ(path.distance, 11.65);
  EXPECT_THAT(path.instructions, ElementsAre("Exit the bedroom. ",
                                             "Stra\xC3\x9F"
                                             "e."));
  EXPECT_EQ(path.id, "");
  EXPECT_EQ(path.group, std::nullopt);
  EXPECT_TRUE(std::holds_alternative<NearEnd>(path.goal));
  ASSERT_EQ(path.details.size(), 2U);
  EXPECT_THAT(path.details[0].tokens, ElementsAre(101, 6164, 102));
  EXPECT_THAT(path.details[1].tokens, ElementsAre(101, 102));
  EXPECT_EQ(path.details[0].id, "");
  EXPECT_EQ(read.paths[1].distance, std::nullopt);
  EXPECT_TRUE(read.paths[1].goal_hidden());
  EXPECT_THAT(read.paths[1].details[0].tokens, ElementsAre(101, 2147483647, 102));
  EXPECT_EQ(again(read), read.paths);
}

TEST(R2rFamily, IsAListOrLines) {
  const std::string one =
      R"({"scan": "s", "path_id": 1, "path": ["v0"], "heading": 0, "instructions": ["Go."]})";
  const std::string two = edited(one, "1", "2");
  const Annotations list = parse("[" + one + "," + two + "]");
  ASSERT_EQ(list.paths.size(), 2U);
  EXPECT_EQ(parse(one + "\r\n\n " + two + "\n").paths, list.paths);
  EXPECT_EQ(parse("\xEF\xBB\xBF" + one + "\n" + two).paths, list.paths);
  EXPECT_THAT(parse("[]").paths, IsEmpty());
}

TEST(R2rFamily, IsR2rWithoutTokens) {
  Annotations plain = parse(kEncoded);
  for (PathAnnotation& path : plain.paths) path.details.clear();
  const std::string text = to_r2r_family(plain);
  EXPECT_EQ(text, to_json(plain));
  EXPECT_EQ(parse(text).paths, parse_annotations(text, "r.json", "val").paths);
  EXPECT_EQ(again(plain), plain.paths);
}

TEST(R2rFamily, KeepsWhichTokensAreEmpty) {
  const Annotations read = parse(edited(kEncoded, "[[101, 6164, 102], [101, 102]]", "[[], []]"));
  EXPECT_EQ(read.paths[0].details, std::vector<InstructionDetails>(2));
  EXPECT_EQ(again(read), read.paths);
}

TEST(R2rFamily, HasInstructionsOfTheirOwnForPretraining) {
  const Annotations read = parse(kLines);
  ASSERT_EQ(read.paths.size(), 3U);
  EXPECT_EQ(read.paths[0].path_id, 4332);
  EXPECT_EQ(read.paths[0].group, 4332);
  EXPECT_EQ(read.paths[0].scan, "s");
  EXPECT_EQ(read.paths[0].heading, Radians(4.055));
  EXPECT_THAT(read.paths[0].path, ElementsAre("v0", "v1"));
  EXPECT_EQ(read.paths[0].distance, std::nullopt);
  EXPECT_THAT(read.paths[0].instructions, ElementsAre(""));
  ASSERT_EQ(read.paths[0].details.size(), 1U);
  EXPECT_EQ(read.paths[0].details[0].id, "4332_0");
  EXPECT_THAT(read.paths[0].details[0].tokens, ElementsAre(101, 102));
  EXPECT_EQ(read.paths[1].path_id, 4332);
  EXPECT_EQ(read.paths[1].group, 4332);
  EXPECT_EQ(read.paths[1].heading, Radians(0));
  EXPECT_EQ(read.paths[1].details[0].id, "4332_1");
  EXPECT_EQ(read.paths[2].path_id, 7);
  const std::string lines = to_r2r_family(read);
  EXPECT_EQ(lines.substr(0, lines.find('\n')),
            R"({"instr_id":"4332_0","scan":"s","heading":4.055,"path":["v0","v1"],)"
            R"("instr_encoding":[101,102]})");
  EXPECT_EQ(again(read), read.paths);
}

TEST(R2rFamily, HasTurningPointsInR2rBack) {
  const Annotations read = parse(kBack, Task::kR2rBack);
  EXPECT_EQ(read.task, Task::kR2rBack);
  ASSERT_EQ(read.paths.size(), 2U);
  EXPECT_EQ(read.paths[0].goal, NamedGoal(NamedTurningPoint{"v1"}));
  EXPECT_EQ(read.paths[1].goal, NamedGoal(HiddenGoal{}));
  EXPECT_FALSE(read.paths[0].goal_hidden());
  EXPECT_TRUE(read.paths[1].goal_hidden());
  EXPECT_EQ(again(read), read.paths);
}

TEST(R2rFamily, ReadsOverWhatR4rAdds) {
  const std::string text =
      R"([{"distance": 20.1, "first_path_id": 4332, "second_path_id": 6250, "heading": 4.055,
      "instructions": ["ab"], "path": ["v0", "v1"], "path_id": 0, "scan": "s",
      "shortest_path": ["v0", "v1"], "shortest_path_distance": 9.7}])";
  const Annotations read = parse(text, Task::kR4r);
  EXPECT_EQ(read.task, Task::kR4r);
  EXPECT_EQ(read.paths[0].distance, 20.1);
  EXPECT_THAT(read.paths[0].details, IsEmpty());
  EXPECT_EQ(again(read), read.paths);
}

TEST(R2rFamily, NamesFieldPlaceAndWhatIsAllowedOfEntries) {
  const std::string large = "\"" + std::string(kMostRecordBytes, 'a') + "\"";
  const struct {
    const char* name;
    std::string text;
    std::string fault;
  } rows[]{
      {"empty", "", "r.json: $: the file is empty"},
      {"blank", "\n \n", "r.json: $: the file is empty"},
      {"cut", std::string(kEncoded).substr(0, 100), "the file ends too early"},
      {"no list", "3", "r.json: $[0]: number 3, not an object"},
      {"lists in a list", "[[]]", "$[0]: array of 0, not an object"},
      {"NaN", edited(kEncoded, "4.055", "NaN"),
       "$[0].heading: line 3, column 14: NaN and Infinity"},
      {"no scan", edited(kEncoded, "\"scan\"", "\"scene\""), "$[0]: has no field \"scan\""},
      {"no instructions", edited(kEncoded, "\"instructions\"", "\"texts\""),
       "$[0]: has no field \"instructions\""},
      {"an empty text for an id", edited(kEncoded, "4332", "\"\""), "$[0].path_id: an empty id"},
      {"id given twice", edited(kEncoded, "\"path_id\": 8", "\"path_id\": 8, \"path_id\": 9"),
       "$[1].path_id: given twice"},
      {"id of another", edited(kEncoded, "\"path_id\": 8", "\"path_id\": 4332"),
       "$[1].path_id: 4332 stands at $[0] already"},
      {"huge id", edited(kEncoded, "4332", "9223372036854775808"),
       "$[0].path_id: number 9223372036854775808, not a whole number"},
      {"huge heading", edited(kEncoded, "4.055", "1e999"), "r.json: $"},
      {"empty path", edited(kEncoded, "[\"v3\"]", "[]"), "$[1].path: no viewpoint"},
      {"path as text", edited(kEncoded, "[\"v3\"]", "\"v3\""),
       "$[1].path: string \"v3\", not an array"},
      {"negative distance", edited(kEncoded, "11.65", "-11.65"),
       "$[0].distance: -11.65 is no length in metres"},
      {"text for instructions", edited(kEncoded, "[\"Go.\"]", "\"Go.\""),
       "$[1].instructions: string \"Go.\", not an array"},
      {"fewer tokens", edited(kEncoded, ", [101, 102]]", "]"),
       "$[0].instr_encodings: 1 lists of tokens; 2 are expected, one for each instruction"},
      {"more tokens", edited(kEncoded, "[[101, 2147483647, 102]]", "[[], []]"),
       "$[1].instr_encodings: 2 lists of tokens; 1 are expected"},
      {"tokens of no list", edited(kEncoded, "[[101, 2147483647, 102]]", "[101, 102]"),
       "$[1].instr_encodings: 2 lists of tokens; 1 are expected"},
      {"a token for a list", edited(kEncoded, "[[101, 2147483647, 102]]", "[101]"),
       "$[1].instr_encodings[0]: number 101, not an array"},
      {"no tokens at all", edited(kEncoded, "[[101, 2147483647, 102]]", "null"),
       "$[1].instr_encodings: null, not an array"},
      {"a negative token", edited(kEncoded, "6164", "-1"),
       "$[0].instr_encodings[0][1]: -1 is no token id"},
      {"a huge token", edited(kEncoded, "2147483647", "2147483648"),
       "$[1].instr_encodings[0][1]: 2147483648 is no token id"},
      {"a token with a point", edited(kEncoded, "6164", "6164.5"),
       "$[0].instr_encodings[0][1]: number 6164.5, not a whole number"},
      {"an instruction among entries", edited(kEncoded, "\"path_id\": 8", "\"instr_id\": \"8_0\""),
       "$[1]: has no field \"path_id\""},
      {"too large", "[" + large + "]", "$[0]: 4194306 bytes; 4194304 are allowed"},
      {"deep", std::string(5000, '['), "r.json: $"},
      {"something after", std::string(kEncoded) + "]", "r.json: $"},
      {"a turning point", kBack, "$[0].midstop: a turning point, as R2R-Back has them"},
  };
  for (const auto& row : rows) EXPECT_THAT(faults_of(row.text), HasSubstr(row.fault)) << row.name;
}

TEST(R2rFamily, NamesFieldPlaceAndWhatIsAllowedOfInstructions) {
  const auto with_id = [](const std::string& id) { return edited(kLines, "\"4332_1\"", id); };
  const struct {
    const char* name;
    std::string text;
    std::string fault;
  } rows[]{
      {"an id that is a number", with_id("4332"), "$[1].instr_id: number 4332, not a string"},
      {"an id without a line", with_id("\"4332\""),
       "$[1].instr_id: string \"4332\", not <path_id>_<k>, such as \"4332_0\""},
      {"no path_id", with_id("\"_1\""), "$[1].instr_id: string \"_1\", not <path_id>_<k>"},
      {"no k", with_id("\"4332_\""), "$[1].instr_id: string \"4332_\", not <path_id>_<k>"},
      {"a negative k", with_id("\"4332_-1\""), "not <path_id>_<k>"},
      {"words for ids", with_id("\"path_one\""), "not <path_id>_<k>"},
      {"the id of another", with_id("\"4332_0\""),
       "$[1].instr_id: \"4332_0\" stands at $[0] already"},
      {"no tokens", edited(kLines, ", \"instr_encoding\": []", ""),
       "$[1]: has no field \"instr_encoding\""},
      {"a text for tokens", edited(kLines, "[101, 102]", "\"[101]\""),
       "$[0].instr_encoding: string \"[101]\", not an array"},
      {"lists of tokens", edited(kLines, "[101, 102]", "[[101]]"),
       "$[0].instr_encoding[0]: array of 1, not a whole number"},
      {"no path", edited(kLines, "\"path\": [\"v2\"], ", ""), "$[2]: has no field \"path\""},
      {"an empty path", edited(kLines, "[\"v2\"]", "[]"), "$[2].path: no viewpoint"},
      {"a heading of no number", edited(kLines, "4.055", "null"),
       "$[0].heading: null, not a number"},
      {"an entry among instructions", edited(kLines, "\"instr_id\": \"7_0\"", "\"path_id\": 7"),
       "$[2]: has no field \"instr_id\""},
      {"a cut line", edited(kLines, "[101, 102]}", "[101,"), "r.json:1: $"},
      {"a list over lines", "{\n}", "r.json:1: $"},
  };
  for (const auto& row : rows) EXPECT_THAT(faults_of(row.text), HasSubstr(row.fault)) << row.name;
}

TEST(R2rFamily, NamesWhatIsWrongWithTurningPoints) {
  const struct {
    const char* name;
    std::string text;
    std::string fault;
  } rows[]{
      {"none", edited(kBack, ", \"midstop\": \"v1\"", ""),
       "$[0]: has no field \"midstop\", which paths of R2R-Back have"},
      {"a number", edited(kBack, "\"midstop\": \"v1\"", "\"midstop\": 1"),
       "$[0].midstop: number 1, not a string"},
      {"null", edited(kBack, "\"midstop\": \"v1\"", "\"midstop\": null"),
       "$[0].midstop: null, not a string"},
      {"two", edited(kBack, "\"midstop\"", "\"midstop\": \"v0\", \"midstop\""),
       "$[0].midstop: given twice"},
      {"none in lines", kLines, "$[0]: has no field \"midstop\""},
  };
  for (const auto& row : rows) {
    EXPECT_THAT(faults_of(row.text, Task::kR2rBack), HasSubstr(row.fault)) << row.name;
  }
}

TEST(R2rFamily, ListsAllFaultsAtOnce) {
  std::string text = edited(kEncoded, "11.65", "-1");
  text = edited(text, "6164", "null");
  text = edited(text, "\"heading\": 0", "\"heading\": \"0\"");
  EXPECT_THAT(faults_of(text),
              AllOf(HasSubstr("$[0].distance"), HasSubstr("$[0].instr_encodings[0][1]: null"),
                    HasSubstr("$[1].heading: string")));
  std::string many = "[";
  for (int i = 0; i < 3000; ++i) many += "1,";
  EXPECT_THAT(faults_of(many + "1]"),
              AllOf(HasSubstr("... and 990 more"), HasSubstr("$[1000]: not read from here on")));
}

TEST(R2rFamily, DoesNotWriteWhatItCouldNotRead) {
  Annotations annotations = parse(kEncoded);
  annotations.paths[1].heading = Radians(std::numeric_limits<double>::infinity());
  EXPECT_THROW(to_r2r_family(annotations), ArgumentError);
  annotations = parse(kBack, Task::kR2rBack);
  annotations.paths[0].goal = NamedTurningPoint{"v\xFF"};
  EXPECT_THROW(to_r2r_family(annotations), ArgumentError);
}

TEST(R2rFamily, MayBePacked) {
  const tests::TemporaryFolder folder("r2r_family");
  const auto file = folder.path() / "R2R_val.json.gz";
  const std::string packed = gzip(kEncoded, 6);
  write_file_atomically(file, packed);
  const Annotations plain = parse_annotations(kEncoded, file.string(), "val");
  EXPECT_EQ(load_annotations(file, "val").paths, plain.paths);
  EXPECT_EQ(load_annotations(file, "val").file, file.string());
  write_file_atomically(file, packed.substr(0, packed.size() / 2));
  EXPECT_THAT(tests::refusal<FileError>([&] { load_annotations(file, "val"); }),
              HasSubstr("R2R_val.json.gz"));
}

struct Counts {
  std::size_t items = 0, instructions = 0, scans = 0, viewpoints = 0, nodes = 0, characters = 0;
  friend bool operator==(const Counts&, const Counts&) = default;
};

Counts counts_of(const Annotations& annotations) {
  Counts counts;
  std::set<std::string> scans;
  std::set<std::pair<std::string, std::string>> viewpoints;
  for (const PathAnnotation& path : annotations.paths) {
    ++counts.items;
    counts.instructions += path.instructions.size();
    counts.nodes += path.path.size();
    scans.insert(path.scan);
    for (const std::string& viewpoint : path.path) viewpoints.emplace(path.scan, viewpoint);
    for (const std::string& text : path.instructions) {
      for (std::size_t at = 0; at < text.size(); ++counts.characters) {
        at += utf8_length(std::string_view(text).substr(at));
      }
    }
  }
  counts.scans = scans.size();
  counts.viewpoints = viewpoints.size();
  return counts;
}

TEST(R2rFamily, OfRealSplits) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real annotations";
  const struct {
    const char* split;
    Counts counts;
  } splits[]{{"train", {4675, 14039, 61, 5626, 28066, 1923985}},
             {"val_seen", {340, 1021, 56, 1560, 2065, 140981}},
             {"val_unseen", {783, 2349, 11, 749, 4671, 319808}},
             {"test", {1391, 4173, 18, 908, 1391, 575208}}};
  for (const auto& [split, counts] : splits) {
    const std::string text = read_text_file(data->annotations(split));
    const Annotations read = parse_r2r_family(text, "", split, Task::kR2r);
    EXPECT_EQ(counts_of(read), counts) << split;
    EXPECT_EQ(read.paths, parse_annotations(text, "", split).paths) << split;
    EXPECT_EQ(again(read), read.paths) << split;
  }
}

// Files made from R2R's for tests of scores.
TEST(R2rFamily, OfRecordedFiles) {
  const struct {
    const char* name;
    Task task;
    std::size_t items, instructions, nodes;
  } files[]{{"r2r_back_val_seen_synthetic", Task::kR2rBack, 60, 180, 662},
            {"r2r_back_val_unseen_synthetic", Task::kR2rBack, 60, 180, 636},
            {"r2r_last_val_seen_synthetic", Task::kR2rLast, 60, 180, 370},
            {"r2r_last_val_unseen_synthetic", Task::kR2rLast, 60, 180, 366},
            {"r4r_val_seen_subset", Task::kR4r, 59, 531, 726},
            {"r4r_val_unseen_subset", Task::kR4r, 80, 720, 995}};
  for (const auto& one : files) {
    const auto text = tests::recorded_annotations(std::string(one.name) + ".json.gz");
    if (!text) GTEST_SKIP() << tests::kNoRecordedAnnotations;
    const Annotations read = parse_r2r_family(*text, one.name, "val", one.task);
    const Counts counts = counts_of(read);
    EXPECT_EQ(counts.items, one.items) << one.name;
    EXPECT_EQ(counts.instructions, one.instructions) << one.name;
    EXPECT_EQ(counts.nodes, one.nodes) << one.name;
    EXPECT_EQ(again(read), read.paths) << one.name;
    for (const PathAnnotation& path : read.paths) {
      if (one.task != Task::kR2rBack) {
        EXPECT_EQ(path.goal, NamedGoal(NearEnd{}));
        continue;
      }
      // They go there and back by the same way.
      EXPECT_EQ(path.goal, NamedGoal(NamedTurningPoint{path.path[path.path.size() / 2]}));
      EXPECT_EQ(path.path.front(), path.path.back());
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks::formats
