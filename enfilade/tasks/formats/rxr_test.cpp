#include "enfilade/tasks/formats/readers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/metrics.h"
#include "tests/support/recorded_annotations.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tasks::formats {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
const std::string kLine =
    R"({"path_id": 11, "split": "val_seen", "scan": "square", "heading": 3.25, )"
    R"("path": ["v0", "v1", "v0"], "instruction_id": 26, "annotator_id": 19, )"
    R"("language": "hi-IN", "instruction": "\u0906\u092a um here", "timed_instruction": )"
    R"([{"start_time": 0.4, "word": "\u0906\u092a", "end_time": 1.0}, {"word": "um"}, )"
    R"({"word": "here", "start_time": 2}], "edit_distance": 0.111})";
const std::string kTest =
    R"({"split": "test_standard", "scan": "square", "heading": 0, "path": ["v2"], )"
    R"("instruction_id": 29, "language": "en-US", "instruction": "Go.", "timed_instruction": []})";
const std::string kWalk =
    R"({"demonstration_id": 36, "instruction_id": 26, "annotator_id": 43, "path": ["v0", "v1"], )"
    R"("metrics": {"ne": 0, "sr": 1.0, "spl": 0.5, "dtw": 2.5, "ndtw": 0.75, "sdtw": 0.25}})";

std::string edited(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string guide_faults(const std::string& text) {
  return tests::refusal<InvalidInput>([&] { parse_rxr_guide(text, "g.jsonl", "val"); });
}

std::string follower_faults(const std::string& text) {
  return tests::refusal<InvalidInput>([&] { parse_demonstrations(text, "f.jsonl"); });
}

TEST(RxrGuide, ReadsALine) {
  const Annotations read = parse_rxr_guide(kLine, "g.jsonl", "val_seen");
  EXPECT_EQ(read.split, "val_seen");
  EXPECT_EQ(read.file, "g.jsonl");
  EXPECT_EQ(read.task, Task::kRxr);
  ASSERT_EQ(read.paths.size(), 1U);
  const PathAnnotation& entry = read.paths[0];
  EXPECT_EQ(entry.path_id, 11);
  EXPECT_EQ(entry.id, "11");
  EXPECT_EQ(entry.group, 11);
  EXPECT_EQ(entry.scan, "square");
  EXPECT_EQ(entry.heading, Radians(3.25));
  EXPECT_THAT(entry.path, ElementsAre("v0", "v1", "v0"));
  EXPECT_EQ(entry.distance, std::nullopt);
  EXPECT_EQ(entry.goal, NamedGoal(NearEnd{}));
  EXPECT_FALSE(entry.goal_hidden());
  EXPECT_THAT(entry.instructions, ElementsAre("\xE0\xA4\x86\xE0\xA4\xAA um here"));
  ASSERT_EQ(entry.details.size(), 1U);
  EXPECT_EQ(entry.details[0].id, "11_26");
  EXPECT_EQ(entry.details[0].language, "hi-IN");
  EXPECT_THAT(entry.details[0].words,
              ElementsAre(TimedWord{"\xE0\xA4\x86\xE0\xA4\xAA", 0.4, 1.0}, TimedWord{"um", {}, {}},
                          TimedWord{"here", 2.0, {}}));
  EXPECT_THAT(entry.details[0].tokens, IsEmpty());
}

TEST(RxrGuide, TestLinesGoByTheirInstruction) {
  const Annotations read = parse_rxr_guide(kTest, "g.jsonl", "test_standard");
  ASSERT_EQ(read.paths.size(), 1U);
  EXPECT_EQ(read.paths[0].path_id, 29);
  EXPECT_EQ(read.paths[0].id, "29");
  EXPECT_EQ(read.paths[0].group, std::nullopt);
  EXPECT_EQ(read.paths[0].details.at(0).id, "29");
  EXPECT_TRUE(read.paths[0].goal_hidden());
}

TEST(RxrGuide, LinesOfAPathAreAGroupInListsToo) {
  const std::string other = edited(kLine, "26", "27");
  for (const std::string& text : {kLine + "\n" + other + "\n\n" + kTest + "\r\n",
                                  "[" + kLine + ", " + other + ", " + kTest + "]"}) {
    const Annotations read = parse_rxr_guide(text, "g.jsonl", "val");
    ASSERT_EQ(read.paths.size(), 3U);
    EXPECT_EQ(read.paths[0].group, read.paths[1].group);
    EXPECT_EQ(read.paths[1].details.at(0).id, "11_27");
    EXPECT_EQ(read.paths[2].group, std::nullopt);
  }
  EXPECT_THAT(parse_rxr_guide("[]", "g.jsonl", "val").paths, IsEmpty());
}

// As `cat a.gz b.gz` and `gzip -c >> guide.gz` make it.
TEST(RxrGuide, MayBePackedInParts) {
  const tests::TemporaryFolder made("guide");
  const auto file = made.path() / "rxr_made_guide.jsonl.gz";
  const std::string other = edited(kLine, "26", "27");
  write_file_atomically(file, gzip("\xEF\xBB\xBF" + kLine + "\r\n", 6) + gzip(other + "\r\n", 9));
  const Annotations read = load_annotations(file, "val_seen", Task::kRxr);
  EXPECT_EQ(read.paths.size(), 2U);
}

TEST(RxrGuide, ReadsTokensAndLinesWithoutTimes) {
  const std::string encoded =
      edited(kLine, "\"edit_distance\"", "\"instr_encoding\": [0, 250001, 2], \"edit_distance\"");
  EXPECT_THAT(parse_rxr_guide(encoded, "", "").paths.at(0).details.at(0).tokens,
              ElementsAre(0, 250001, 2));
  const std::string plain = edited(kTest, ", \"timed_instruction\": []", "");
  EXPECT_EQ(parse_rxr_guide(plain, "", "").paths, parse_rxr_guide(kTest, "", "").paths);
}

TEST(RxrGuide, NamesFieldPlaceAndWhatIsAllowed) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "$: the file is empty"},
      {"3", "$[0]: number 3, not an object"},
      {"{}", "$[0]: has no field \"scan\""},
      {kLine + "\n[1]", "$[1]: array of 1, not an object"},
      {kLine + "\n" + kLine.substr(0, 90), "g.jsonl:2: $.path[1]: line 1, column 90"},
      {"[" + kLine + ", ", "the file ends too early"},
      {std::string(3000, '['), "[not-json]"},
      {"{\"scan\": " + std::string(3000, '['), "[not-json]"},
      {edited(kLine, "3.25", "NaN"), "NaN and Infinity are not JSON"},
      {edited(kLine, "3.25", "1e999"), "[not-json]"},
      {edited(kLine, "\"square\"", "\"\xFF\""), "[not-json]"},
      {edited(kLine, "3.25", "\"3.25\""), "$[0].heading: string \"3.25\", not a number"},
      {edited(kLine, "11", "\"11\""), "$[0].path_id: string \"11\", not a whole number"},
      {edited(kLine, "11", "-11"), "$[0].path_id: -11 is no id; 0 and more are"},
      {edited(kLine, "11", "18446744073709551615"), "$[0].path_id: number 18446744073709551615"},
      {edited(kLine, "26", "26.5"), "$[0].instruction_id: number 26.5, not a whole number"},
      {edited(kLine, "26", "-1"), "$[0].instruction_id: -1 is no id"},
      {edited(kLine, "26", "26, \"instruction_id\": 26"), "$[0].instruction_id: given twice"},
      {edited(kLine, "\"path_id\": 11, ", ""),
       "$[0].path: 3 viewpoints, not the start alone, as there is no \"path_id\""},
      {edited(kLine, R"(["v0", "v1", "v0"])", "[]"), "$[0].path: no viewpoint; the start"},
      {edited(kLine, R"(["v0", "v1", "v0"])", "\"v0\""), "$[0].path: string \"v0\", not an array"},
      {edited(kLine, "\"v1\"", "[\"v1\"]"), "$[0].path[1]: array of 1, not a string"},
      {edited(kLine, "hi-IN", "hi"),
       "$[0].language: \"hi\" is no language of RxR; en-IN, en-US, hi-IN, te-IN are"},
      {edited(kLine, "\"instruction\"", "\"text\""), "$[0]: has no field \"instruction\""},
      {edited(kLine, "\"um\"", "null"), "$[0].timed_instruction[1].word: null, not a string"},
      {edited(kLine, "\"word\": \"um\"", ""), "$[0].timed_instruction[1]: has no field \"word\""},
      {edited(kLine, "0.4", "\"0.4\""), "$[0].timed_instruction[0].start_time: string \"0.4\""},
      {edited(kLine, "1.0", "[]"), "$[0].timed_instruction[0].end_time: array"},
      {edited(kTest, "[]", "{}"), "$[0].timed_instruction: object, not an array"},
      {edited(kTest, "[]", "[], \"instr_encoding\": [-1]"), "$[0].instr_encoding[0]: -1 is no"},
      {edited(kTest, "[]", "[], \"instr_encoding\": \"0 2\""), "$[0].instr_encoding: string"},
      {kLine + "\n" + kTest + "\n" + edited(kLine, "11", "12"),
       "$[2].instruction_id: \"26\" stands at $[0] already [repeated-id]"},
  };
  for (const auto& [text, message] : cases) EXPECT_THAT(guide_faults(text), HasSubstr(message));
  EXPECT_EQ(guide_faults(kLine), "accepted");
}

TEST(RxrGuide, ListsAllFaultsAtOnce) {
  EXPECT_THAT(guide_faults(edited(edited(kLine, "3.25", "{}"), "hi-IN", "") + "\n7"),
              AllOf(HasSubstr("$[0].heading: object"), HasSubstr("$[0].language: \"\" is no"),
                    HasSubstr("$[1]: number 7")));
  std::string many;
  for (int k = 0; k < 2000; ++k) many += "0\n";
  EXPECT_THAT(guide_faults(many), HasSubstr("... and 990 more"));
  EXPECT_THAT(guide_faults(many), HasSubstr("$[1000]: not read from here on"));
}

// A file that is read in parts by several threads: 9 MB.
TEST(RxrGuide, LargeFilesAreReadInTheirOrder) {
  const auto line = [](int k) {
    return edited(kLine, "\"instruction_id\": 26", "\"instruction_id\": " + std::to_string(k));
  };
  std::string text;
  constexpr int kLines = 25000;
  for (int k = 0; k < kLines; ++k) text += line(k) + '\n';
  const Annotations read = parse_rxr_guide(text, "g.jsonl", "val");
  ASSERT_EQ(read.paths.size(), std::size_t{kLines});
  for (int k = 0; k < kLines; ++k) {
    ASSERT_EQ(read.paths[static_cast<std::size_t>(k)].details[0].id, "11_" + std::to_string(k));
  }
  // What is wrong has its place in the whole file; the line that is not JSON, its line.
  const std::string wrong = edited(line(kLines), "\"hi-IN\"", "\"de-DE\"");
  EXPECT_THAT(guide_faults(text + wrong + '\n' + line(7)),
              AllOf(HasSubstr("$[25000].language: \"de-DE\""),
                    HasSubstr("$[25001].instruction_id: \"7\" stands at $[7] already")));
  EXPECT_THAT(guide_faults(text + "{\"path_id\": }\n"), HasSubstr("g.jsonl:25001"));
  // More faults than are kept.
  std::string all_wrong;
  for (int k = 0; k < kLines; ++k) all_wrong += edited(line(k), "\"hi-IN\"", "\"de-DE\"") + '\n';
  EXPECT_THAT(guide_faults(all_wrong), HasSubstr("$[0].language"));
}

TEST(RxrGuide, ReadsWhatItWrites) {
  const std::string encoded =
      edited(edited(kLine, "26", "27"), "\"edit", "\"instr_encoding\": [0, 2], \"edit");
  const Annotations read =
      parse_rxr_guide(kLine + "\n" + encoded + "\n" + kTest, "g.jsonl", "val_seen");
  const std::string written = to_rxr_guide(read);
  EXPECT_EQ(std::ranges::count(written, '\n'), 3);
  EXPECT_THAT(written, HasSubstr("\"split\":\"val_seen\""));
  EXPECT_EQ(parse_rxr_guide(written, "g.jsonl", "val_seen").paths, read.paths);
}

TEST(RxrGuide, DoesNotWriteWhatItCouldNotRead) {
  const auto refusal_of = [](const auto& change) {
    Annotations annotations = parse_rxr_guide(kLine, "g.jsonl", "val");
    change(annotations.paths[0]);
    return tests::refusal<ArgumentError>([&] { to_rxr_guide(annotations); });
  };
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.heading = Radians(kNone); }),
              HasSubstr("path 11: heading nan, not a finite number"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.details[0].words[1].end = kNone; }),
              HasSubstr("end_time nan"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.scan = "\xFF"; }), HasSubstr("not UTF-8"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.details.clear(); }),
              HasSubstr("1 instructions with details of 0"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.details[0].id = "12_26"; }),
              HasSubstr("instruction id \"12_26\", not \"11_\" and a number"));
}

TEST(RxrFollowers, ReadsALine) {
  const auto read = parse_demonstrations(kWalk, "f.jsonl");
  EXPECT_THAT(read,
              ElementsAre(Demonstration{36, 26, 43, {"v0", "v1"}, 0, 1, 0.5, 2.5, 0.75, 0.25}));
}

TEST(RxrFollowers, ReadsWhatItWrites) {
  auto walks = parse_demonstrations(kWalk + "\n" + edited(kWalk, "36", "37"), "f.jsonl");
  walks[1].ndtw = 0.1 + 0.2;
  const std::string written = to_text(walks);
  EXPECT_EQ(std::ranges::count(written, '\n'), 2);
  EXPECT_EQ(parse_demonstrations(written, "f.jsonl"), walks);
}

TEST(RxrFollowers, DoesNotWriteWhatItCouldNotRead) {
  const auto refusal_of = [](const auto& change) {
    auto walks = parse_demonstrations(kWalk, "f.jsonl");
    change(walks[0]);
    return tests::refusal<ArgumentError>([&] { to_text(walks); });
  };
  EXPECT_THAT(refusal_of([](Demonstration& w) { w.dtw = kNone; }),
              HasSubstr("demonstration 36: dtw nan, not a finite number"));
  EXPECT_THAT(refusal_of([](Demonstration& w) { w.annotator_id = -1; }), HasSubstr("negative id"));
  EXPECT_THAT(refusal_of([](Demonstration& w) { w.path.clear(); }), HasSubstr("no viewpoint"));
  EXPECT_THAT(refusal_of([](Demonstration& w) { w.path[0] = "\xFF"; }), HasSubstr("not UTF-8"));
}

TEST(RxrFollowers, NamesFieldPlaceAndWhatIsAllowed) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"[7]", "$[0]: number 7, not an object"},
      {"{}", "$[0]: has no field \"demonstration_id\""},
      {kWalk.substr(0, 50), "[not-json]"},
      {edited(kWalk, "36", "-36"), "$[0].demonstration_id: -36 is no id"},
      {edited(kWalk, "26", "\"26\""), "$[0].instruction_id: string \"26\", not a whole"},
      {edited(kWalk, "43", "null"), "$[0].annotator_id: null, not a whole number"},
      {edited(kWalk, R"(["v0", "v1"])", "[]"), "$[0].path: no viewpoint"},
      {edited(kWalk, R"(["v0", "v1"])", "\"v0\""), "$[0].path: string \"v0\", not an array"},
      {edited(kWalk, "\"sdtw\"", "\"SDTW\""), "$[0].metrics: has no field \"sdtw\""},
      {edited(kWalk, "2.5", "\"2.5\""), "$[0].metrics.dtw: string \"2.5\", not a number"},
      {edited(kWalk, "2.5", "Infinity"), "NaN and Infinity are not JSON"},
      {edited(kWalk, "{\"ne\"", "[{\"ne\"") + "]}", "[not-json]"},
      {kWalk + "\n" + edited(kWalk, "26", "27"), "$[1].demonstration_id: \"36\" stands at $[0]"},
  };
  for (const auto& [text, message] : cases) EXPECT_THAT(follower_faults(text), HasSubstr(message));
  EXPECT_EQ(follower_faults(kWalk), "accepted");
}

struct Counts {
  std::size_t paths = 0, nodes = 0, words = 0, untimed = 0;
  friend bool operator==(const Counts&, const Counts&) = default;
};

Counts count(const Annotations& annotations) {
  Counts counts;
  std::set<std::optional<std::int64_t>> groups;
  for (const PathAnnotation& entry : annotations.paths) {
    groups.insert(entry.group);
    counts.nodes += entry.path.size();
    for (const TimedWord& word : entry.details[0].words) {
      ++counts.words;
      if (!word.start && !word.end) ++counts.untimed;
    }
  }
  counts.paths = groups.size();
  return counts;
}

TEST(RxrRecorded, GuidesAreWholeAndReadBackEqual) {
  const std::map<std::string, Counts> expected{{"val_seen", {44, 888, 4039, 178}},
                                               {"val_unseen", {44, 879, 3945, 159}}};
  for (const auto& [split, counts] : expected) {
    const auto text = tests::recorded_annotations("rxr_" + split + "_guide_synthetic.jsonl.gz");
    if (!text) GTEST_SKIP() << tests::kNoRecordedAnnotations;
    const Annotations read = parse_rxr_guide(*text, split, split);
    EXPECT_EQ(read.paths.size(), 110U);
    EXPECT_EQ(count(read), counts) << split;
    std::map<std::string, std::size_t> languages;
    for (const PathAnnotation& entry : read.paths) ++languages[entry.details[0].language];
    EXPECT_EQ(languages, (std::map<std::string, std::size_t>{
                             {"en-IN", 28}, {"en-US", 28}, {"hi-IN", 27}, {"te-IN", 27}}));
    EXPECT_EQ(parse_rxr_guide(to_rxr_guide(read), split, split).paths, read.paths);
  }
}

TEST(RxrRecorded, TokensAndHiddenGoals) {
  for (const std::string split : {"val_seen", "val_unseen"}) {
    const auto plain = tests::recorded_annotations("rxr_" + split + "_guide_synthetic.jsonl.gz");
    const auto text =
        tests::recorded_annotations("rxr_" + split + "_guide_enc_xlmr_synthetic.jsonl.gz");
    if (!plain || !text) GTEST_SKIP() << tests::kNoRecordedAnnotations;
    Annotations encoded = parse_rxr_guide(*text, split, split);
    ASSERT_EQ(encoded.paths.size(), 12U);
    Annotations first = parse_rxr_guide(*plain, split, split);
    first.paths.resize(12);
    for (PathAnnotation& entry : encoded.paths) {
      auto& tokens = entry.details[0].tokens;
      ASSERT_GE(tokens.size(), 2U);
      EXPECT_EQ(tokens.front(), 0);
      EXPECT_EQ(tokens.back(), 2);
      tokens.clear();
    }
    EXPECT_EQ(encoded.paths, first.paths) << "the same lines, with tokens";
  }
  const auto test =
      tests::recorded_annotations("rxr_test_standard_public_guide_synthetic.jsonl.gz");
  if (!test) GTEST_SKIP() << tests::kNoRecordedAnnotations;
  const Annotations read = parse_rxr_guide(*test, "test", "test_standard");
  EXPECT_EQ(read.paths.size(), 12U);
  for (const PathAnnotation& entry : read.paths) {
    EXPECT_TRUE(entry.goal_hidden());
    EXPECT_EQ(entry.details[0].id, std::to_string(entry.path_id));
  }
  EXPECT_EQ(parse_rxr_guide(to_rxr_guide(read), "test", "test_standard").paths, read.paths);
}

std::vector<ViewpointIndex> in_graph(const std::vector<std::string>& path,
                                     const graph::NavGraph& graph) {
  std::vector<ViewpointIndex> found;
  for (const std::string& id : path) found.push_back(graph.find(id).value());
  return found;
}

TEST(RxrRecorded, FollowersHaveTheMetricsOfTheirWalks) {
  const std::map<std::string, std::size_t> walks{{"val_seen", 101}, {"val_unseen", 113}};
  for (const auto& [split, n] : walks) {
    const auto guide = tests::recorded_annotations("rxr_" + split + "_guide_synthetic.jsonl.gz");
    const auto text = tests::recorded_annotations("rxr_" + split + "_follower_synthetic.jsonl.gz");
    if (!guide || !text) GTEST_SKIP() << tests::kNoRecordedAnnotations;
    const auto graphs =
        graph::GraphSet::open(scan::DataRoot::from_environment().value().connectivity());
    std::map<std::string, PathAnnotation> guides;
    for (const PathAnnotation& entry : parse_rxr_guide(*guide, split, split).paths) {
      guides[entry.details[0].id.substr(entry.id.size() + 1)] = entry;
    }
    const auto followers = parse_demonstrations(*text, split);
    EXPECT_EQ(followers.size(), n);
    for (const Demonstration& walk : followers) {
      const PathAnnotation& reference = guides.at(std::to_string(walk.instruction_id));
      const graph::NavGraph& graph = graphs->graph(graphs->find(reference.scan).value());
      const EpisodeMetrics metrics =
          compute_metrics(graph, in_graph(walk.path, graph), in_graph(reference.path, graph));
      EXPECT_NEAR(walk.ne, metrics.nav_error, 1e-9);
      EXPECT_EQ(walk.sr, metrics.success);
      EXPECT_NEAR(walk.spl, metrics.spl, 1e-9);
      EXPECT_NEAR(walk.dtw, metrics.dtw, 1e-9);
      EXPECT_NEAR(walk.ndtw, metrics.ndtw, 1e-9);
      EXPECT_NEAR(walk.sdtw, metrics.sdtw, 1e-9);
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks::formats
