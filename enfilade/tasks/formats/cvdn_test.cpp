#include "enfilade/tasks/formats/readers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

#include "tests/support/recorded_annotations.h"
#include "tests/support/refusal.h"

namespace enfilade::tasks::formats {
namespace EN_UNIT {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const std::string kInstance =
    R"({"inst_idx": 12, "scan": "square", "target": "plant", "start_pano": {"heading": 1.25, )"
    R"("elevation": 0.0, "pano": "v0"}, "nav_camera": [{"any": []}], "dialog_history": [)"
    R"({"nav_idx": 0, "role": "navigator", "message": "Left?"}, )"
    R"({"nav_idx": 2, "role": "oracle", "message": "Yes, \"left\"."}], )"
    R"("nav_history": ["v3", "v0"], "game_idx": 3, "end_panos": ["v2", "v3"], )"
    R"("player_path": ["v0", "v1", "v2"], "planner_path": ["v0", "v1"], "R2R_success": 1.0})";
const std::string kTest =
    R"({"inst_idx": 13, "scan": "square", "target": "sink", "start_pano": {"heading": 0, )"
    R"("pano": "v2"}, "dialog_history": []})";
const std::string kEncoded =
    R"({"instr_id": "1001", "scan": "square", "target": "plant", "start_pano": "v2", )"
    R"("start_heading": 0.5, "end_panos": ["v0"], "nav_steps": ["v0", "v1", "v2", "v3"], )"
    R"("nav_idx": 2, "instr_encoding": [101, 2023, 102]})";

std::string edited(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

PathAnnotation read_one(const std::string& instance) {
  const Annotations read = parse_cvdn("[" + instance + "]", "c.json", "val");
  EXPECT_EQ(read.paths.size(), 1U);
  return read.paths.at(0);
}

std::string faults_of(const std::string& text) {
  return tests::refusal<InvalidInput>([&] { parse_cvdn(text, "c.json", "val"); });
}

std::string encoded_faults(const std::string& text) {
  return tests::refusal<InvalidInput>([&] { parse_cvdn_encoded(text, "c.json", "val"); });
}

TEST(Cvdn, ReadsAnInstance) {
  const Annotations read = parse_cvdn("[" + kInstance + "]", "c.json", "val_seen");
  EXPECT_EQ(read.split, "val_seen");
  EXPECT_EQ(read.file, "c.json");
  EXPECT_EQ(read.task, Task::kCvdn);
  ASSERT_EQ(read.paths.size(), 1U);
  const PathAnnotation& entry = read.paths[0];
  EXPECT_EQ(entry.path_id, 12);
  EXPECT_EQ(entry.id, "12");
  EXPECT_EQ(entry.group, 3);
  EXPECT_EQ(entry.scan, "square");
  EXPECT_EQ(entry.heading, Radians(1.25));
  EXPECT_EQ(entry.distance, std::nullopt);
  EXPECT_THAT(entry.path, ElementsAre("v0", "v1", "v2"));
  EXPECT_EQ(entry.goal,
            NamedGoal(NamedRegion{"plant", {"v2", "v3"}, {"v0", "v1", "v2"}, {"v0", "v1"}}));
  EXPECT_FALSE(entry.goal_hidden());
  EXPECT_THAT(entry.instructions, ElementsAre("<NAV> Left? <ORA> Yes, \"left\". <TAR> plant"));
  ASSERT_EQ(entry.details.size(), 1U);
  EXPECT_EQ(entry.details[0].id, "12");
  EXPECT_THAT(entry.details[0].turns, ElementsAre(DialogueTurn{"navigator", "Left?", 0},
                                                  DialogueTurn{"oracle", "Yes, \"left\".", 2}));
}

TEST(Cvdn, HidesTheGoalOfTestInstances) {
  const PathAnnotation entry = read_one(kTest);
  EXPECT_TRUE(entry.goal_hidden());
  EXPECT_THAT(entry.path, ElementsAre("v2"));
  EXPECT_EQ(entry.group, std::nullopt);
  EXPECT_THAT(entry.instructions, ElementsAre("<TAR> sink")) << "no dialogue yet";
  EXPECT_THAT(entry.details.at(0).turns, IsEmpty());
}

TEST(Cvdn, TrustsThePlayerWhoPassedThePlannersEnd) {
  const auto path = [](const std::string& player, const std::string& planner) {
    return read_one(edited(edited(kInstance, R"("planner_path": ["v0", "v1"])",
                                  "\"planner_path\": " + planner),
                           R"(["v0", "v1", "v2"])", player))
        .path;
  };
  EXPECT_THAT(path(R"(["v0", "v1", "v2"])", R"(["v0", "v1"])"), ElementsAre("v0", "v1", "v2"));
  EXPECT_THAT(path(R"(["v0", "v3"])", R"(["v0", "v1"])"), ElementsAre("v0", "v1"));
  EXPECT_THAT(path(R"(["v0"])", R"(["v0", "v1"])"), ElementsAre("v0", "v1"));
  EXPECT_THAT(path(R"(["v0", "v1"])", R"(["v0"])"), ElementsAre("v0")) << "the start is no pass";
  EXPECT_THAT(path(R"(["v0", "v1", "v0"])", R"(["v0"])"), ElementsAre("v0", "v1", "v0"));
  EXPECT_THAT(path(R"(["v0"])", R"(["v0"])"), ElementsAre("v0"));
}

TEST(Cvdn, APathOfOneViewpointHidesNothing) {
  const PathAnnotation entry = read_one(edited(
      edited(kInstance, R"(["v0", "v1", "v2"])", R"(["v0"])"), R"(["v0", "v1"])", R"(["v0"])"));
  EXPECT_FALSE(entry.goal_hidden());
  EXPECT_THAT(read_one(edited(kInstance, "\"game_idx\": 3, ", "")).group,
              ::testing::Eq(std::nullopt));
}

TEST(Cvdn, NamesFieldPlaceAndWhatIsAllowed) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"[3]", "$[0]: number 3, not an object"},
      {"{}", "$[0]: has no field \"inst_idx\""},
      {"[" + kInstance.substr(0, 200), "[not-json]"},
      {std::string(3000, '['), "[not-json]"},
      {edited(kInstance, "1.25", "NaN"), "NaN and Infinity are not JSON"},
      {edited(kInstance, "1.25", "null"), "$[0].start_pano.heading: null, not a number"},
      {edited(kInstance, "12", "\"12\""), "$[0].inst_idx: string \"12\", not a whole number"},
      {edited(kInstance, "12", "-12"), "$[0].inst_idx: -12 is no id; 0 and more are"},
      {edited(kInstance, "12", "12, \"inst_idx\": 12"), "$[0].inst_idx: given twice"},
      {edited(kInstance, "\"pano\": \"v0\"", "\"pano\": 0"), "$[0].start_pano.pano: number 0, not"},
      {edited(kTest, "{\"heading\": 0, \"pano\": \"v2\"}", "\"v2\""),
       "$[0].start_pano: string \"v2\", not an object"},
      {edited(kInstance, "\"navigator\"", "\"guide\""),
       "$[0].dialog_history[0].role: \"guide\", neither \"navigator\" nor \"oracle\""},
      {edited(kInstance, "\"nav_idx\": 2", "\"nav_idx\": -2"),
       "$[0].dialog_history[1].nav_idx: -2 is no number of steps"},
      {edited(kInstance, "\"nav_idx\": 2, ", ""),
       "$[0].dialog_history[1]: has no field \"nav_idx\""},
      {edited(kInstance, "\"Left?\"", "[\"Left?\"]"),
       "$[0].dialog_history[0].message: array of 1, not a string"},
      {edited(kTest, "[]", "\"none\""), "$[0].dialog_history: string \"none\", not an array"},
      {edited(kInstance, "\"game_idx\": 3", "\"game_idx\": \"3\""), "$[0].game_idx: string"},
      {edited(kInstance, R"(["v2", "v3"])", "[]"), "$[0].end_panos: no viewpoint; one at least"},
      {edited(kInstance, R"(["v2", "v3"])", "\"v2\""), "$[0].end_panos: string \"v2\", not an"},
      {edited(kInstance, R"(["v2", "v3"])", "[\"v2\", null]"), "$[0].end_panos[1]: null, not a"},
      {edited(kInstance, R"(["v0", "v1", "v2"])", "[]"), "$[0].player_path: no viewpoint"},
      {edited(kInstance, R"(["v0", "v1"])", "\"v0\""), "$[0].planner_path: string \"v0\", not"},
      {edited(kInstance, R"(["v0", "v1"])", R"(["v1", "v0"])"),
       "$[0].planner_path[0]: \"v1\", not \"v0\", the start"},
      {edited(kInstance, R"(["v0", "v1", "v2"])", R"(["v2"])"),
       "$[0].player_path[0]: \"v2\", not \"v0\", the start"},
      {edited(kInstance, "\"planner_path\"", "\"planner\""),
       "$[0]: has \"end_panos\", but no field \"planner_path\""},
      {edited(kInstance, "\"end_panos\"", "\"endpanos\""),
       "$[0]: has \"player_path\", but no field \"end_panos\""},
      {"[" + kInstance + ", " + kTest + ", " + kInstance + "]",
       "$[2].inst_idx: \"12\" stands at $[0] already [repeated-id]"},
  };
  for (const auto& [text, message] : cases) EXPECT_THAT(faults_of(text), HasSubstr(message));
  EXPECT_EQ(faults_of(kInstance), "accepted");
}

TEST(Cvdn, ListsAllFaultsAtOnce) {
  EXPECT_THAT(faults_of("[" + edited(edited(kInstance, "1.25", "\"\""), "\"oracle\"", "\"\"") +
                        ", {\"inst_idx\": 1}, null]"),
              AllOf(HasSubstr("$[0].start_pano.heading: string"),
                    HasSubstr("$[0].dialog_history[1].role: \"\", neither"),
                    HasSubstr("$[1]: has no field \"target\""), HasSubstr("$[2]: null")));
}

TEST(CvdnEncoded, ReadsAnInstance) {
  const Annotations read = parse_cvdn_encoded("[" + kEncoded + "]", "c.json", "val_seen");
  EXPECT_EQ(read.task, Task::kCvdn);
  ASSERT_EQ(read.paths.size(), 1U);
  const PathAnnotation& entry = read.paths[0];
  EXPECT_EQ(entry.path_id, 1001);
  EXPECT_EQ(entry.id, "1001");
  EXPECT_EQ(entry.group, std::nullopt);
  EXPECT_EQ(entry.scan, "square");
  EXPECT_EQ(entry.heading, Radians(0.5));
  EXPECT_THAT(entry.path, ElementsAre("v2", "v3")) << "two steps had been walked";
  EXPECT_EQ(entry.goal, NamedGoal(NamedRegion{"plant", {"v0"}, {"v2", "v3"}, {}}));
  EXPECT_THAT(entry.instructions, ElementsAre(""));
  ASSERT_EQ(entry.details.size(), 1U);
  EXPECT_EQ(entry.details[0].id, "1001");
  EXPECT_THAT(entry.details[0].tokens, ElementsAre(101, 2023, 102));
}

TEST(CvdnEncoded, TakesTextsAsIdsAndInstancesWithoutTarget) {
  const std::string text =
      edited(edited(kEncoded, "1001", "game_7"), "\"target\": \"plant\", ", "");
  const Annotations read = parse_cvdn_encoded("[" + kEncoded + "," + text + "]", "", "");
  ASSERT_EQ(read.paths.size(), 2U);
  EXPECT_EQ(read.paths[1].id, "game_7");
  EXPECT_EQ(read.paths[1].details.at(0).id, "game_7");
  EXPECT_EQ(read.paths[1].path_id, 1);
  EXPECT_EQ(std::get<NamedRegion>(read.paths[1].goal).target, "");
}

TEST(CvdnEncoded, HidesTheGoalOfTestInstances) {
  const std::string hidden = edited(kEncoded, "\"end_panos\": [\"v0\"], ", "");
  const std::string start =
      edited(hidden, R"("nav_steps": ["v0", "v1", "v2", "v3"], "nav_idx": 2, )", "");
  for (const std::string& text : {hidden, start}) {
    const Annotations read = parse_cvdn_encoded(text, "", "test");
    EXPECT_TRUE(read.paths.at(0).goal_hidden());
    EXPECT_THAT(read.paths.at(0).path, ElementsAre("v2"));
  }
}

TEST(CvdnEncoded, NamesFieldPlaceAndWhatIsAllowed) {
  const std::vector<std::pair<std::string, std::string>> cases{
      {"[\"\"]", "$[0]: string \"\", not an object"},
      {"{}", "$[0]: has no field \"instr_id\""},
      {"[" + kEncoded, "the file ends too early"},
      {edited(kEncoded, "\"1001\"", "1001"), "$[0].instr_id: number 1001, not a string"},
      {edited(kEncoded, "\"1001\"", "\"\""), "$[0].instr_id: an empty id"},
      {edited(kEncoded, "\"v2\"", "{\"pano\": \"v2\"}"), "$[0].start_pano: object, not a string"},
      {edited(kEncoded, "\"v2\"", "\"v0\""), "$[0].nav_steps[2]: \"v2\", not \"v0\", the start"},
      {edited(kEncoded, "0.5", "1e400"), "[not-json]"},
      {edited(kEncoded, "[\"v0\"]", "[]"), "$[0].end_panos: no viewpoint"},
      {edited(kEncoded, "\"nav_idx\": 2", "\"nav_idx\": -1"),
       "$[0].nav_idx: -1, not 0 to 3, a place in \"nav_steps\""},
      {edited(kEncoded, "\"nav_idx\": 2", "\"nav_idx\": 4"), "$[0].nav_idx: 4, not 0 to 3"},
      {edited(kEncoded, "\"nav_idx\": 2", "\"nav_idx\": 2.5"), "$[0].nav_idx: number 2.5, not"},
      {edited(kEncoded, "\"nav_idx\": 2, ", ""),
       "$[0]: has \"end_panos\", but no field \"nav_idx\""},
      {edited(kEncoded, R"(["v0", "v1", "v2", "v3"])", "[]"), "$[0].nav_steps: no viewpoint"},
      {edited(kEncoded, R"(["v0", "v1", "v2", "v3"])", "\"v2\""), "$[0].nav_steps: string"},
      {edited(kEncoded, "2023", "4294967296"), "$[0].instr_encoding[1]: 4294967296 is no token"},
      {edited(kEncoded, "[101, 2023, 102]", "\"101\""), "$[0].instr_encoding: string \"101\""},
      {"[" + kEncoded + "," + kEncoded + "]", "$[1].instr_id: \"1001\" stands at $[0] already"},
  };
  for (const auto& [text, message] : cases) EXPECT_THAT(encoded_faults(text), HasSubstr(message));
  EXPECT_EQ(encoded_faults(kEncoded), "accepted");
}

TEST(Cvdn, ReadsWhatItWrites) {
  const Annotations read = parse_cvdn("[" + kInstance + ", " + kTest + "]", "c.json", "val");
  const std::string written = to_cvdn(read);
  EXPECT_EQ(std::ranges::count(written, '\n'), 4);
  EXPECT_EQ(parse_cvdn(written, "c.json", "val").paths, read.paths);
}

TEST(Cvdn, DoesNotWriteWhatItCouldNotRead) {
  const auto refusal_of = [](const auto& change) {
    Annotations annotations = parse_cvdn("[" + kInstance + "]", "c.json", "val");
    change(annotations.paths[0]);
    return tests::refusal<ArgumentError>([&] { to_cvdn(annotations); });
  };
  const auto region = [](PathAnnotation& p) -> NamedRegion& {
    return std::get<NamedRegion>(p.goal);
  };
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.goal = NearEnd{}; }),
              HasSubstr("instance \"12\": its goal is neither hidden nor a region"));
  EXPECT_THAT(refusal_of([&](PathAnnotation& p) { region(p).viewpoints.clear(); }),
              HasSubstr("its region has no viewpoint"));
  EXPECT_THAT(refusal_of([&](PathAnnotation& p) { region(p).target = "sink"; }),
              HasSubstr("its text ends with \"plant\", not with its region's target, \"sink\""));
  EXPECT_THAT(refusal_of([&](PathAnnotation& p) { region(p).player = {"v1"}; }),
              HasSubstr("does not begin at the start"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.path.pop_back(); }),
              HasSubstr("its path is not the trusted one"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.details[0].turns[0].message = "Right?"; }),
              HasSubstr("its text does not begin with its turns, \"<NAV> Right?"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.details[0].turns[0].nav_step = -1; }),
              HasSubstr("a turn of \"navigator\" at step -1"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.id = "13"; }), HasSubstr("not its number"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.details.clear(); }),
              HasSubstr("1 instructions with details of 0"));
  EXPECT_THAT(refusal_of([](PathAnnotation& p) { p.scan = "\xFF"; }), HasSubstr("not UTF-8"));
}

TEST(CvdnEncoded, ReadsWhatItWrites) {
  const std::string text =
      edited(edited(kEncoded, "1001", "game_7"), "\"target\": \"plant\", ", "");
  const std::string hidden = edited(edited(kEncoded, "1001", "9"), "\"end_panos\": [\"v0\"], ", "");
  const Annotations read =
      parse_cvdn_encoded("[" + kEncoded + "," + text + "," + hidden + "]", "", "");
  EXPECT_EQ(parse_cvdn_encoded(to_cvdn(read), "", "").paths, read.paths);
  Annotations mixed = read;
  mixed.paths[1].instructions[0] = "Go.";
  EXPECT_THAT(tests::refusal<ArgumentError>([&] { to_cvdn(mixed); }),
              HasSubstr("instance \"game_7\": a text, where others have tokens"));
}

struct Counts {
  std::size_t groups = 0, turns = 0, ends = 0, player = 0, planner = 0;
  std::size_t short_player = 0, short_planner = 0;  // of one viewpoint
  std::size_t player_trusted = 0;
  friend bool operator==(const Counts&, const Counts&) = default;
};

// As the benchmark's own code chooses: in its words, not the reader's.
bool trusts_player(const NamedRegion& region) {
  const std::set<std::string> passed(region.player.begin() + 1, region.player.end());
  return passed.contains(region.planner.back());
}

Counts count(const Annotations& annotations) {
  Counts counts;
  std::set<std::int64_t> games;
  for (const PathAnnotation& entry : annotations.paths) {
    const auto& region = std::get<NamedRegion>(entry.goal);
    games.insert(entry.group.value());
    counts.turns += entry.details.at(0).turns.size();
    counts.ends += region.viewpoints.size();
    counts.player += region.player.size();
    counts.planner += region.planner.size();
    counts.short_player += region.player.size() == 1 ? 1 : 0;
    counts.short_planner += region.planner.size() == 1 ? 1 : 0;
    counts.player_trusted += trusts_player(region) ? 1 : 0;
    EXPECT_EQ(entry.path, trusts_player(region) ? region.player : region.planner);
  }
  counts.groups = games.size();
  return counts;
}

TEST(CvdnRecorded, BothFormsHoldTheSameInstances) {
  const std::map<std::string, Counts> expected{
      {"val_seen", {43, 374, 580, 627, 629, 32, 14, 49}},
      {"val_unseen", {43, 374, 468, 531, 622, 34, 16, 44}}};
  for (const auto& [split, counts] : expected) {
    const auto text = tests::recorded_annotations("cvdn_ndh_" + split + "_synthetic.json.gz");
    const auto other = tests::recorded_annotations("cvdn_ndh_" + split + "_enc_synthetic.json.gz");
    if (!text || !other) GTEST_SKIP() << tests::kNoRecordedAnnotations;
    const Annotations read = parse_cvdn(*text, split, split);
    const Annotations encoded = parse_cvdn_encoded(*other, split, split);
    ASSERT_EQ(read.paths.size(), 126U);
    ASSERT_EQ(encoded.paths.size(), 126U);
    EXPECT_EQ(count(read), counts) << split;
    EXPECT_TRUE(parse_cvdn(to_cvdn(read), split, split).paths == read.paths) << split;
    EXPECT_TRUE(parse_cvdn_encoded(to_cvdn(encoded), split, split).paths == encoded.paths);
    for (std::size_t i = 0; i < read.paths.size(); ++i) {
      const PathAnnotation &plain = read.paths[i], &same = encoded.paths[i];
      const auto& region = std::get<NamedRegion>(plain.goal);
      EXPECT_EQ(same.id, plain.id);
      EXPECT_EQ(same.path_id, plain.path_id);
      EXPECT_EQ(same.scan, plain.scan);
      EXPECT_EQ(same.heading, plain.heading);
      EXPECT_EQ(same.path, region.player);
      EXPECT_EQ(same.goal,
                NamedGoal(NamedRegion{region.target, region.viewpoints, region.player, {}}));
      EXPECT_THAT(same.details.at(0).tokens, ElementsAre(101, 2023, 102));
    }
  }
}

TEST(CvdnRecorded, TestInstancesHaveStartsAlone) {
  const auto text = tests::recorded_annotations("cvdn_ndh_test_cleaned_synthetic.json.gz");
  if (!text) GTEST_SKIP() << tests::kNoRecordedAnnotations;
  const Annotations read = parse_cvdn(*text, "test", "test");
  EXPECT_EQ(read.paths.size(), 20U);
  std::size_t turns = 0;
  for (const PathAnnotation& entry : read.paths) {
    EXPECT_TRUE(entry.goal_hidden());
    EXPECT_EQ(entry.path.size(), 1U);
    turns += entry.details.at(0).turns.size();
  }
  EXPECT_EQ(turns, 60U);
  EXPECT_EQ(read.paths.at(1).instructions.at(0),
            "<NAV> Should I go left? <ORA> You are close, look behind you. <TAR> plant");
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks::formats
