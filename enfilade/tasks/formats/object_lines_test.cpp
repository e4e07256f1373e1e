#include "enfilade/tasks/formats/readers.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <utility>
#include <vector>

#include "enfilade/tasks/files.h"
#include "tests/support/graphs.h"
#include "tests/support/refusal.h"

namespace enfilade::tasks::formats {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// SYNTHETIC, with the ids of another data set's buildings.
const std::string kLine =
    R"({"instr_id": "00000-kfPV7w3FaU5_000007_17_0", "scan": "00000-kfPV7w3FaU5", )"
    R"("path": ["000007", "000012"], "pos_vps": ["000012", "000013"], "objid": 17, )"
    R"("instruction": "Find the vase.", "instr_encoding": [101, 5, 102]})";
const std::string kSecond =
    R"({"instr_id": "00000-kfPV7w3FaU5_000007_17_1", "scan": "00000-kfPV7w3FaU5", )"
    R"("path": ["000007", "000012"], "pos_vps": ["000012"], "objid": "17"})";

std::string edited(const std::string& from, const std::string& to) {
  std::string text = kLine;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, text.npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ObjectLines, AreReadAsAnotherReverie) {
  const std::string text = kLine + "\n" + kSecond + "\n";
  EXPECT_EQ(find_task(text), Task::kReverie);
  const Annotations all = tasks::parse_annotations(text, "a.jsonl", "train", Task::kReverie);
  ASSERT_EQ(all.paths.size(), 2U);
  const PathAnnotation& one = all.paths[0];
  EXPECT_EQ(one.scan, "00000-kfPV7w3FaU5");
  EXPECT_THAT(one.path, ElementsAre("000007", "000012"));
  EXPECT_EQ(std::get<NamedObject>(one.goal), (NamedObject{17, {"000012", "000013"}}));
  EXPECT_EQ(one.instructions[0], "Find the vase.");
  EXPECT_THAT(one.details[0].tokens, ElementsAre(101, 5, 102));
  EXPECT_EQ(std::get<NamedObject>(all.paths[1].goal).id, 17);
  EXPECT_EQ(all.paths[1].group, one.group);  // one path, two instructions
}

TEST(ObjectLines, WhatIsWrittenIsReadBackEqual) {
  const Annotations all = parse_object_lines(kLine + "\n" + kSecond, "a.jsonl", "train");
  EXPECT_EQ(parse_object_lines(to_text(all), "a.jsonl", "train").paths, all.paths);
  Annotations other = all;
  other.paths[0].goal = NearEnd{};
  EXPECT_THROW(to_object_lines(other), ArgumentError);
  for (const auto& damage :
       {+[](PathAnnotation& one) { one.details[0].id.clear(); },
        +[](PathAnnotation& one) { one.path.clear(); },
        +[](PathAnnotation& one) { std::get<NamedObject>(one.goal).id = -1; }}) {
    other = all;
    damage(other.paths[0]);
    EXPECT_THROW(to_object_lines(other), ArgumentError);
  }
}

TEST(ObjectLines, ViewpointsThatSeeTheObjectAreTheFiles) {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square("s"));
  const auto set = graph::GraphSet::of(std::move(graphs));
  const std::string line = R"({"instr_id": "a_0", "scan": "s", "path": ["v0", "v1"], )"
                           R"("pos_vps": ["v2", "v1"], "objid": 3})";
  const auto episodes = make_episodes(parse_object_lines(line, "a.jsonl", "train"), set);
  EXPECT_EQ(episodes.episodes[0].instruction_id, "a_0");
  EXPECT_EQ(std::get<SeenObject>(episodes.paths[0].goal).seen_from.size(), 2U);
  const std::string unknown = R"({"instr_id": "a_0", "scan": "s", "path": ["v0", "v1"], )"
                              R"("pos_vps": ["v9"], "objid": 3})";
  EXPECT_THAT(
      tests::refusal([&] { make_episodes(parse_object_lines(unknown, "a.jsonl", "train"), set); }),
      HasSubstr("$[0].pos_vps[0]: viewpoint \"v9\" is not one of"));
}

TEST(ObjectLines, RefusesWhatIsWrong) {
  const std::pair<std::string, std::string> cases[] = {
      {edited(R"("objid": 17, )", ""), "$[0]: has no field \"objid\""},
      {edited(R"("objid": 17)", R"("objid": -1)"), "$[0].objid: -1 is no id"},
      {edited(R"("objid": 17)", R"("objid": "017")"), "\"017\", not the number of an object"},
      {edited(R"("objid": 17)", R"("objid": 1.5)"), "$[0].objid: number 1.5"},
      {edited(R"(["000012", "000013"])", "[]"), "$[0].pos_vps: no viewpoint that sees"},
      {edited(R"(["000012", "000013"])", "[12]"), "$[0].pos_vps[0]: number 12, not a string"},
      {edited(R"(["000007", "000012"])", "[]"), "$[0].path: no viewpoint"},
      {edited(R"("00000-kfPV7w3FaU5_000007_17_0")", "\"\""), "$[0].instr_id: an empty id"},
      {edited("[101, 5, 102]", "[-1]"), "$[0].instr_encoding[0]: -1 is no token id"},
      {kLine + "\n" + kLine, "$[1].instr_id: \"00000-kfPV7w3FaU5_000007_17_0\" stands at $[0]"},
  };
  for (const auto& [text, says] : cases) {
    EXPECT_THAT(tests::refusal([&text = text] { parse_object_lines(text, "a.jsonl", "train"); }),
                HasSubstr(says));
  }
}

// ScaleVLN's paths have texts for ids.
TEST(TextPathIds, AreReadAndWritten) {
  const std::string list =
      R"([{"path_id": "00000-kfPV7w3FaU5_12", "scan": "s", "heading": 0, "path": ["v0", "v1"], )"
      R"("instructions": ["Go.", "Walk."]}, {"path_id": 0, "scan": "s", "heading": 0, )"
      R"("path": ["v0"], "instructions": ["Stay."]}])";
  const Annotations all = parse_r2r_family(list, "a.json", "train", Task::kR2r);
  EXPECT_EQ(all.paths[0].id, "00000-kfPV7w3FaU5_12");
  EXPECT_EQ(parse_r2r_family(to_r2r_family(all), "a.json", "train", Task::kR2r).paths, all.paths);
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square("s"));
  const auto episodes = make_episodes(all, graph::GraphSet::of(std::move(graphs)));
  EXPECT_EQ(episodes.episodes[1].instruction_id, "00000-kfPV7w3FaU5_12_1");

  const std::string line =
      R"({"instr_id": "00000-kfPV7w3FaU5_12_0", "scan": "s", "path": ["v0", "v1"], )"
      R"("instruction": "Go.", "instr_encoding": [101, 102]})";
  const Annotations lines = parse_r2r_family(line, "a.jsonl", "train", Task::kR2r);
  EXPECT_EQ(lines.paths[0].instructions[0], "Go.");
  EXPECT_EQ(parse_r2r_family(to_r2r_family(lines), "a.jsonl", "train", Task::kR2r).paths,
            lines.paths);
  const std::string twice = R"([{"path_id": "a", "scan": "s", "heading": 0, "path": ["v0"], )"
                            R"("instructions": []}, {"path_id": "a", "scan": "s", "heading": 0, )"
                            R"("path": ["v0"], "instructions": []}])";
  EXPECT_THAT(tests::refusal([&] { parse_r2r_family(twice, "a.json", "train", Task::kR2r); }),
              HasSubstr("$[1].path_id: \"a\" stands at $[0] already"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks::formats
