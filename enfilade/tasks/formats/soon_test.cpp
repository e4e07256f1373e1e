#include "enfilade/tasks/formats/readers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <utility>

#include "enfilade/tasks/files.h"
#include "tests/support/recorded_annotations.h"
#include "tests/support/refusal.h"

namespace enfilade::tasks::formats {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Pair;
using ::testing::SizeIs;

const std::string kBox =
    R"({"scan": "square", "image_id": "v2", "heading": 9, "elevation": 9, "obj_name": "vase", )"
    R"("target": {"center": {"heading": 6.25, "elevation": -0.5}, )"
    R"("left_top": {"heading": 6.0, "elevation": -0.25}, )"
    R"("right_top": {"heading": 0.25, "elevation": -0.125}, )"
    R"("right_bottom": {"heading": 0.5, "elevation": -0.75}, )"
    R"("left_bottom": {"heading": 5.5, "elevation": -1}}, "mouse_left_top": {"x": 1, "y": 2}})";
const std::string kEntry =
    R"({"path": [["v0", "v1", "v2"], ["v1", "v2"], ["v0", "v3", "v2"]], "instr_id": "7", )"
    R"("instructions": [["The vase. ", "Round. ", "By a wall. ", "In a hall. ", "The vase."]], )"
    R"("bboxes": [)" +
    kBox + "]}";
const std::string kHidden =
    R"({"path": [["v3"]], "scan": "square", "instructions": [["a", "b", "c", "d", "e"]]})";
const std::string kLine =
    R"({"path_id": "3-17", "scan": "square", "path": ["v0", "v1", "v2"], "instructions": )"
    R"([{"obj_name": "The vase. ", "full": "The vase.", "region": "In a hall. "}, )"
    R"({"full": "It."}], "instr_encodings": [{"full": [101, 7, 102], "obj_name": [101]}, )"
    R"({"full": []}], "bboxes": [)" +
    kBox + "]}";

constexpr Direction direction(double heading, double elevation) {
  return {Radians(heading), Radians(elevation)};
}

NamedBox vase() {
  return {
      "v2",
      "vase",
      direction(6.25, -0.5),
      {direction(6, -0.25), direction(0.25, -0.125), direction(0.5, -0.75), direction(5.5, -1)}};
}

std::string edited(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string faults_of(const std::string& text) {
  return tests::refusal<InvalidInput>([&] { parse_soon(text, "s.json", "train"); });
}

std::string line_faults(const std::string& text) {
  return tests::refusal<InvalidInput>([&] { parse_soon_lines(text, "s.jsonl", "train"); });
}

TEST(Soon, SplitsAnEntryIntoItsAlternatives) {
  const Annotations read = parse_soon("[" + kEntry + "]", "s.json", "val_unseen_house");
  EXPECT_EQ(read.split, "val_unseen_house");
  EXPECT_EQ(read.file, "s.json");
  EXPECT_EQ(read.task, Task::kSoon);
  ASSERT_THAT(read.paths, SizeIs(3));
  for (std::size_t k = 0; k < 3; ++k) {
    const PathAnnotation& entry = read.paths[k];
    EXPECT_EQ(entry.id, "3-" + std::to_string(k));
    EXPECT_EQ(entry.path_id, static_cast<std::int64_t>(k));
    EXPECT_EQ(entry.group, 0);
    EXPECT_EQ(entry.scan, "square") << "the box's";
    EXPECT_EQ(entry.heading, Radians(1.52));
    EXPECT_EQ(entry.distance, std::nullopt);
    EXPECT_FALSE(entry.goal_hidden());
    EXPECT_THAT(entry.instructions, ElementsAre("The vase."));
    ASSERT_THAT(entry.details, SizeIs(1));
    EXPECT_EQ(entry.details[0].id, "");
    EXPECT_THAT(entry.details[0].fields,
                ElementsAre(Pair("obj_name", "The vase. "), Pair("attribute", "Round. "),
                            Pair("relation", "By a wall. "), Pair("region", "In a hall. ")));
    EXPECT_EQ(entry.details[0].entry, "7");
    EXPECT_THAT(std::get<NamedBoxes>(entry.goal).boxes, ElementsAre(vase()));
  }
  EXPECT_THAT(read.paths[0].path, ElementsAre("v0", "v1", "v2"));
  EXPECT_THAT(read.paths[1].path, ElementsAre("v1", "v2"));
  EXPECT_THAT(read.paths[2].path, ElementsAre("v0", "v3", "v2"));
}

TEST(Soon, KeepsTheFirstAlternativeOfAStart) {
  const Annotations read = parse_soon(kEntry, "s.json", "train");
  const auto first = [&](std::size_t k) {
    return std::get<NamedBoxes>(read.paths.at(k).goal).first_alternative;
  };
  EXPECT_THAT(first(0), IsEmpty());
  EXPECT_THAT(first(1), IsEmpty());
  EXPECT_THAT(first(2), ElementsAre("v0", "v1", "v2"));
}

TEST(Soon, NumbersPathsThroughTheFile) {
  const std::string text = "[" + kEntry + ", " + kHidden + "]";
  const std::vector<std::pair<std::string, std::string>> ids{{"train", "0-3"},
                                                             {"val_seen_instrs", "1-3"},
                                                             {"val_unseen_instrs", "2-3"},
                                                             {"val_unseen_house", "3-3"},
                                                             {"test", "4-3"},
                                                             {"mine", "9-3"}};
  for (const auto& [split, id] : ids) {
    const Annotations read = parse_soon(text, "s.json", split);
    ASSERT_THAT(read.paths, SizeIs(4));
    EXPECT_EQ(read.paths[3].id, id);
    EXPECT_EQ(read.paths[3].group, 1);
  }
}

TEST(Soon, HidesTheGoalWithoutBoxes) {
  const std::string empty = edited(kHidden, "\"scan\"", "\"bboxes\": [], \"scan\"");
  for (const std::string& text : {kHidden, empty}) {
    const Annotations read = parse_soon(text, "s.json", "test");
    EXPECT_TRUE(read.paths.at(0).goal_hidden());
    EXPECT_EQ(read.paths[0].goal, NamedGoal(HiddenGoal{}));
    EXPECT_EQ(read.paths[0].scan, "square");
    EXPECT_EQ(read.paths[0].instructions.at(0), "e");
  }
}

TEST(Soon, NamesFieldPlaceAndWhatIsAllowed) {
  const std::string paths = R"([["v0", "v1", "v2"], ["v1", "v2"], ["v0", "v3", "v2"]])";
  const std::vector<std::pair<std::string, std::string>> cases{
      {"[null]", "$[0]: null, not an object"},
      {"{}", "$[0]: has no field \"path\""},
      {edited(kEntry, "\"7\"", "7"), "$[0].instr_id: number 7, not a string"},
      {"[" + kEntry + ", " + kEntry + "]", "$[1].instr_id: \"7\" stands at $[0]"},
      {"[" + kEntry.substr(0, 300), "[not-json]"},
      {"[{\"path\": " + std::string(3000, '['), "[not-json]"},
      {edited(kEntry, paths, "[]"), "$[0].path: no path; a list of one or more"},
      {edited(kEntry, paths, R"(["v0", "v1"])"), "$[0].path[0]: string \"v0\", not an array"},
      {edited(kEntry, R"(["v1", "v2"])", "[]"), "$[0].path[1]: no viewpoint"},
      {edited(kEntry, R"(["v1", "v2"])", R"([["v1"]])"), "$[0].path[1][0]: array of 1, not a"},
      {edited(kEntry, "\"instructions\"", "\"instruction\""), "$[0]: has no field"},
      {edited(kEntry, "\"Round. \", ", ""), "$[0].instructions[0]: list of 4 texts, not of 5"},
      {edited(kEntry, "\"Round. \"", "7"), "$[0].instructions[0][1]: number 7, not a string"},
      {edited(kHidden, R"([["a", "b", "c", "d", "e"]])", R"(["a", "b", "c", "d", "e"])"),
       "$[0].instructions[0]: string \"a\", not an array"},
      {edited(kHidden, "\"scan\": \"square\", ", ""), "$[0]: names no scan"},
      {edited(kEntry, "\"bboxes\": [", "\"bboxes\": [" + edited(kBox, "square", "round") + ", "),
       "$[0].bboxes[1].scan: \"square\", where the entry is in \"round\" [two-scans]"},
      {edited(kEntry, "\"instr_id\"", "\"scan\": \"round\", \"instr_id\""),
       "$[0].bboxes[0].scan: \"square\", where the entry is in \"round\""},
      {edited(kEntry, "\"bboxes\": [", "\"bboxes\": {\"v2\": "), "[not-json]"},
      {edited(kHidden, "\"scan\"", "\"bboxes\": {}, \"scan\""), "$[0].bboxes: object, not an"},
      {edited(kEntry, "\"image_id\"", "\"image\""), "$[0].bboxes[0]: has no field \"image_id\""},
      {edited(kEntry, "\"vase\"", "5"), "$[0].bboxes[0].obj_name: number 5, not a string"},
      {edited(kEntry, "\"left_top\"", "\"top_left\""),
       "$[0].bboxes[0].target: has no field \"left_top\""},
      {edited(kEntry, "6.0", "null"), "$[0].bboxes[0].target.left_top.heading: null, not"},
      {edited(kEntry, "-0.75", "NaN"), "NaN and Infinity are not JSON"},
      {edited(kEntry, "-0.75", "-1e999"), "[not-json]"},
      {edited(kEntry, R"({"heading": 6.25, "elevation": -0.5})", "[6.25, -0.5]"),
       "$[0].bboxes[0].target.center: array of 2, not an object"},
  };
  for (const auto& [text, message] : cases) EXPECT_THAT(faults_of(text), HasSubstr(message));
  EXPECT_EQ(faults_of(kEntry), "accepted");
}

TEST(Soon, ListsAllFaultsAtOnce) {
  EXPECT_THAT(faults_of("[" + edited(edited(kEntry, "\"v2\"", "{}"), "6.0", "\"\"") + ", 5]"),
              AllOf(HasSubstr("$[0].path[0][2]: object"),
                    HasSubstr("$[0].bboxes[0].target.left_top.heading: string"),
                    HasSubstr("$[1]: number 5")));
}

// 1 MB that would take 3.5 GB.
TEST(Soon, DoesNotRepeatAnEntryWithoutLimit) {
  std::string paths, boxes;
  for (int k = 0; k < 12000; ++k) paths += (k == 0 ? "[\"v\"]" : ",[\"v\"]");
  for (int k = 0; k < 2000; ++k) boxes += (k == 0 ? "" : ",") + kBox;
  EXPECT_THAT(
      faults_of("{\"path\": [" + paths + "], \"instructions\": [], \"bboxes\": [" + boxes + "]}"),
      HasSubstr("$[0].path: with these 12000 paths, alternatives would repeat"));
}

TEST(Soon, ReadsWhatItWrites) {
  const Annotations read =
      parse_soon("[" + kEntry + ", " + edited(kHidden, "{", "{\"instr_id\": \"0\", ") + ", " +
                     edited(kEntry, "\"7\"", "\"b_7\"") + "]",
                 "s.json", "val_unseen_house");
  ASSERT_THAT(read.paths, SizeIs(7));
  EXPECT_EQ(read.paths[3].details[0].entry, "0");
  const std::string written = to_released_soon(read);
  EXPECT_EQ(std::ranges::count(written, '\n'), 5) << "an entry a line";
  EXPECT_EQ(parse_soon(written, "s.json", "val_unseen_house").paths, read.paths);
}

TEST(Soon, NumbersEntriesThatHaveNoId) {
  Annotations read = parse_soon("[" + kHidden + ", " + kHidden + "]", "s.json", "test");
  EXPECT_EQ(read.paths[1].details[0].entry, std::nullopt);
  Annotations again = parse_soon(to_released_soon(read), "s.json", "test");
  EXPECT_EQ(again.paths.at(1).details[0].entry, "1");
  again.paths[1].details[0].entry = "0";
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { to_released_soon(again); }),
              HasSubstr("path \"4-1\": its entry has the instr_id \"0\" of another"));
}

TEST(Soon, DoesNotWriteWhatItCouldNotRead) {
  const auto refusal_of = [](const auto& change) {
    Annotations annotations = parse_soon("[" + kEntry + "]", "s.json", "train");
    change(annotations.paths[1]);
    return tests::refusal<ArgumentError>([&] { to_released_soon(annotations); });
  };
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.instructions[0] = "Go."; }),
              HasSubstr("path \"0-1\": of the group of \"0-0\", but differs from it"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) {
                p.details[0].fields.erase(p.details[0].fields.begin() + 3);
              }),
              HasSubstr("3 texts beside the whole of instruction 0, not 4"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.path.clear(); }), HasSubstr("no viewpoint"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.goal = NearEnd{}; }),
              HasSubstr("neither hidden nor boxes"));
}

TEST(SoonLines, ReadsALine) {
  const Annotations read = parse_soon_lines(kLine + "\n", "s.jsonl", "val_unseen_house");
  EXPECT_EQ(read.split, "val_unseen_house");
  EXPECT_EQ(read.task, Task::kSoon);
  ASSERT_THAT(read.paths, SizeIs(1));
  const PathAnnotation& entry = read.paths[0];
  EXPECT_EQ(entry.id, "3-17");
  EXPECT_EQ(entry.path_id, 17);
  EXPECT_EQ(entry.group, std::nullopt);
  EXPECT_EQ(entry.scan, "square");
  EXPECT_EQ(entry.heading, Radians(1.52));
  EXPECT_THAT(entry.path, ElementsAre("v0", "v1", "v2"));
  EXPECT_EQ(entry.goal, NamedGoal(NamedBoxes{{vase()}, {}}));
  EXPECT_THAT(entry.instructions, ElementsAre("The vase.", "It."));
  ASSERT_THAT(entry.details, SizeIs(2));
  EXPECT_THAT(entry.details[0].fields,
              ElementsAre(Pair("obj_name", "The vase. "), Pair("region", "In a hall. ")));
  EXPECT_THAT(entry.details[0].tokens, ElementsAre(101, 7, 102));
  EXPECT_THAT(entry.details[1].fields, IsEmpty());
  EXPECT_THAT(entry.details[1].tokens, IsEmpty());
}

TEST(SoonLines, ReadsOverPseudoLabels) {
  const std::string labelled =
      edited(kLine, "\"obj_name\": \"vase\"",
             R"("obj_name": "vase", "pseudo_label": {"obj_id": "5", "idx": 2})");
  EXPECT_EQ(parse_soon_lines(labelled, "", "").paths, parse_soon_lines(kLine, "", "").paths);
}

TEST(SoonLines, NamesFieldPlaceAndWhatIsAllowed) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"7", "$[0]: number 7, not an object"},
      {"{}", "$[0]: has no field \"scan\""},
      {kLine + "\n" + kLine.substr(0, 100), "s.jsonl:2: "},
      {edited(kLine, "\"3-17\"", "17"), "$[0].path_id: number 17, not a string"},
      {edited(kLine, "3-17", "17"), "$[0].path_id: \"17\", not \"<split number>-<running number>"},
      {edited(kLine, "3-17", "3--1"), "$[0].path_id: \"3--1\", not"},
      {edited(kLine, "3-17", ""), "$[0].path_id: an empty id"},
      {edited(kLine, "3-17", "3-99999999999999999999"), "$[0].path_id: \"3-9999"},
      {edited(kLine, R"(["v0", "v1", "v2"])", R"([["v0"]])"), "$[0].path[0]: array of 1, not a"},
      {edited(kLine, R"(["v0", "v1", "v2"])", "[]"), "$[0].path: no viewpoint"},
      {edited(kLine, "{\"full\": \"It.\"}", "\"It.\""),
       "$[0].instructions[1]: string \"It.\", not an object"},
      {edited(kLine, "{\"full\": \"It.\"}", "{}"), "$[0].instructions[1]: has no field \"full\""},
      {edited(kLine, "\"In a hall. \"", "null"), "$[0].instructions[0].region: null, not a"},
      {edited(kLine, ", {\"full\": []}", ""),
       "$[0].instr_encodings: encodings of 1 instructions, not of 2"},
      {edited(kLine, "{\"full\": []}", "[]"), "$[0].instr_encodings[1]: array of 0, not an object"},
      {edited(kLine, "{\"full\": []}", "{\"fully\": []}"),
       "$[0].instr_encodings[1]: has no field \"full\""},
      {edited(kLine, "[101, 7, 102]", "[101, -7]"), "$[0].instr_encodings[0].full[1]: -7 is no"},
      {edited(kLine, "\"square\"", "\"round\""), "$[0].bboxes[0].scan: \"square\", where the"},
      {edited(kLine, "6.25", "Infinity"), "NaN and Infinity are not JSON"},
      {kLine + "\n\n" + edited(kLine, "v0", "v3"), "$[1].path_id: \"3-17\" stands at $[0]"},
  };
  for (const auto& [text, message] : cases) EXPECT_THAT(line_faults(text), HasSubstr(message));
  EXPECT_EQ(line_faults(kLine), "accepted");
}

TEST(SoonLines, ReadsWhatItWrites) {
  const std::string hidden =
      R"({"path_id": "3-18", "scan": "square", "path": ["v3"], "instructions": [{"full": "e"}]})";
  const std::string waiting = edited(edited(hidden, "18", "19"), "{\"full\": \"e\"}", "");
  const Annotations read =
      parse_soon_lines(kLine + "\n" + hidden + "\n" + waiting, "s.jsonl", "val");
  ASSERT_THAT(read.paths, SizeIs(3));
  const std::string written = to_soon_lines(read);
  EXPECT_EQ(std::ranges::count(written, '\n'), 3);
  EXPECT_EQ(parse_soon_lines(written, "s.jsonl", "val").paths, read.paths);
}

TEST(SoonLines, WritesReleasedEntriesWithoutWhatTiesThem) {
  Annotations read = parse_soon("[" + kEntry + ", " + kHidden + "]", "s.json", "test");
  const Annotations again = parse_soon_lines(to_soon_lines(read), "s.jsonl", "test");
  for (PathAnnotation& entry : read.paths) {
    entry.group.reset();
    for (auto& details : entry.details) details.entry.reset();
    if (auto* const goal = std::get_if<NamedBoxes>(&entry.goal)) goal->first_alternative.clear();
  }
  EXPECT_EQ(again.paths, read.paths);
}

TEST(SoonLines, DoesNotWriteWhatItCouldNotRead) {
  const auto refusal_of = [](const auto& change) {
    Annotations annotations = parse_soon_lines(kLine, "s.jsonl", "val");
    change(annotations.paths[0]);
    return tests::refusal<ArgumentError>([&] { to_soon_lines(annotations); });
  };
  EXPECT_THAT(refusal_of([](PathAnnotation& p) {
                std::get<NamedBoxes>(p.goal).boxes[0].corners[1].heading =
                    Radians(std::numeric_limits<double>::infinity());
              }),
              HasSubstr("path \"3-17\": heading inf and elevation -0.125 of a box"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.instructions[0] = "\xFF"; }),
              HasSubstr("not UTF-8"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.goal = NearEnd{}; }),
              HasSubstr("neither hidden nor boxes"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.goal = NamedBoxes{}; }),
              HasSubstr("neither hidden nor boxes"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.details.pop_back(); }),
              HasSubstr("2 instructions with details of 1"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.id = ""; }), HasSubstr("no SOON path's"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { std::ranges::reverse(p.details[0].fields); }),
              HasSubstr("field \"obj_name\" is unknown, or not in SOON's order"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.details[0].fields[0].first = "full"; }),
              HasSubstr("field \"full\" is unknown"));
}

TEST(SoonRecorded, BothFormsHoldTheSamePaths) {
  struct Expected {
    std::string split;
    std::size_t nodes, boxes, tied;  // tied: to the first alternative of their start
  };
  for (const Expected& expected :
       {Expected{"val_seen_instrs", 814, 324, 8}, Expected{"val_unseen_house", 897, 334, 8}}) {
    const std::string name = "soon_" + expected.split;
    const auto text = tests::recorded_annotations(name + "_synthetic.json.gz");
    const auto other = tests::recorded_annotations(name + "_enc_synthetic.jsonl.gz");
    if (!text || !other) GTEST_SKIP() << tests::kNoRecordedAnnotations;
    Annotations read = parse_soon(*text, name, expected.split);
    const Annotations lines = parse_soon_lines(*other, name, expected.split);
    std::set<std::int64_t> entries;
    std::size_t nodes = 0, boxes = 0, tied = 0, instructions = 0;
    for (PathAnnotation& entry : read.paths) {
      auto& goal = std::get<NamedBoxes>(entry.goal);
      entries.insert(std::exchange(entry.group, std::nullopt).value());
      nodes += entry.path.size();
      boxes += goal.boxes.size();
      instructions += entry.instructions.size();
      tied += goal.first_alternative.empty() ? 0 : 1;
      goal.first_alternative.clear();
      for (InstructionDetails& details : entry.details) {
        EXPECT_EQ(details.entry, std::to_string(entries.size() - 1));
        details.entry.reset();
        details.tokens = {101, 2023, 102};
      }
    }
    EXPECT_EQ(entries.size(), 50U);
    EXPECT_EQ(read.paths.size(), 107U);
    EXPECT_EQ(instructions, 157U);
    EXPECT_EQ(nodes, expected.nodes);
    EXPECT_EQ(boxes, expected.boxes);
    EXPECT_EQ(tied, expected.tied);
    EXPECT_EQ(lines.paths, read.paths) << "ids, scans, paths, boxes, texts";
    EXPECT_EQ(parse_soon_lines(to_soon_lines(lines), name, expected.split).paths, lines.paths);
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks::formats
