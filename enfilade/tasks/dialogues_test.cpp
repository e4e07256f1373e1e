#include "enfilade/tasks/dialogues.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <utility>

#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// SYNTHETIC, in the form of the data set's page.
const std::string kDialogue =
    R"({"idx": 12, "scan": "s", "target": "plant", "start_pano": "v0", "end_panos": ["v2", "v3"], )"
    R"("nav_steps": ["v0", "v1", "v2"], "planner_nav_steps": ["v0", "v3"], "dialog_history": )"
    R"([{"nav_idx": 0, "role": "navigator", "message": "Left?"}, )"
    R"({"nav_idx": 1, "role": "oracle", "message": "Yes."}], "stop_history": [1, 2], )"
    R"("nav_camera": [{"nav_idx": 0, "message": [{"heading": 1.5}]}], "navigator": 3, )"
    R"("navigator_mturk": "A", "navigator_quality": 4, "navigator_avg_quality": 4.5, "oracle": 5, )"
    R"("oracle_mturk": "B", "oracle_quality": null, "problem": 0, "R2R_spl": 0.5})";

std::string edited(const std::string& from, const std::string& to) {
  std::string text = kDialogue;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, text.npos) << from;
  return "[" + text.replace(at, from.size(), to) + "]";
}

std::string refusal_of(const std::string& text) {
  return tests::refusal([&] { parse_dialogues(text, "made.json"); });
}

TEST(Dialogues, AreReadWhole) {
  const auto dialogues = parse_dialogues("[" + kDialogue + "]", "made.json");
  ASSERT_EQ(dialogues.size(), 1U);
  const Dialogue& one = dialogues[0];
  EXPECT_EQ(one.id, 12);
  EXPECT_EQ(one.target, "plant");
  EXPECT_THAT(one.ends, ElementsAre("v2", "v3"));
  EXPECT_THAT(one.planned, ElementsAre("v0", "v3"));
  EXPECT_THAT(one.stops, ElementsAre(1, 2));
  ASSERT_EQ(one.turns.size(), 2U);
  EXPECT_EQ(one.turns[1], (DialogueTurn{"oracle", "Yes.", 1}));
  EXPECT_EQ(one.navigator, (DialoguePerson{3, "A", 4.0, 4.5}));
  EXPECT_FALSE(one.oracle.quality);
  EXPECT_EQ(one.camera, R"([{"nav_idx":0,"message":[{"heading":1.5}]}])");
  EXPECT_FALSE(one.goal_hidden());
}

TEST(Dialogues, WhatIsWrittenIsReadBackEqual) {
  const std::string hidden = R"({"idx": 13, "scan": "s", "target": "bed", "start_pano": "v1"})";
  const auto dialogues = parse_dialogues("[" + kDialogue + "," + hidden + "]", "made.json");
  EXPECT_TRUE(dialogues[1].goal_hidden());
  const std::string text = to_json(dialogues);
  EXPECT_EQ(parse_dialogues(text, "made.json"), dialogues);
  EXPECT_EQ(parse_dialogues(kDialogue + "\n" + hidden + "\n", "made.jsonl"), dialogues);
  const tests::TemporaryFolder folder("dialogues");
  write_file_atomically(folder.path() / "train.json.gz", gzip(text, 6));
  EXPECT_EQ(load_dialogues(folder.path() / "train.json.gz"), dialogues);
  EXPECT_EQ(parse_dialogues(to_json(std::vector<Dialogue>()), "made.json").size(), 0U);
}

TEST(Dialogues, RefusesWhatIsWrong) {
  const std::pair<std::string, std::string> cases[] = {
      {edited(R"("idx": 12, )", ""), "$[0]: has no field \"idx\""},
      {edited("12", "-1"), "$[0].idx: -1 is no id; 0 and more are"},
      {edited(R"("start_pano": "v0")", R"("start_pano": 0)"), "$[0].start_pano: number 0"},
      {edited(R"("end_panos": ["v2", "v3"], )", ""),
       "has \"nav_steps\", but no field \"end_panos\""},
      {edited(R"(["v2", "v3"])", "[]"), "$[0].end_panos: no viewpoint; one at least"},
      {edited(R"(["v0", "v1", "v2"])", "[]"), "$[0].nav_steps: no viewpoint"},
      {edited(R"(["v0", "v1", "v2"])", R"(["v1", "v1", "v2"])"),
       "$[0].nav_steps[0]: \"v1\", not \"v0\", the start"},
      {edited(R"(["v0", "v3"])", R"(["v3"])"),
       "$[0].planner_nav_steps[0]: \"v3\", not \"v0\", the start"},
      {edited(R"("nav_idx": 1)", R"("nav_idx": 3)"),
       "$[0].dialog_history[1].nav_idx: 3, not 0 to 2, a place in \"nav_steps\""},
      {edited(R"("nav_idx": 1)", R"("nav_idx": -1)"), "-1 is no number of steps"},
      {edited("[1, 2]", "[1, 9]"), "$[0].stop_history[1]: 9, not 0 to 2"},
      {edited("[1, 2]", "[1.5]"), "$[0].stop_history[0]: number 1.5, not a whole number"},
      {edited(R"("role": "oracle")", R"("role": "guide")"), "neither \"navigator\" nor \"oracle\""},
      {edited(R"("navigator_quality": 4)", R"("navigator_quality": "good")"),
       "$[0].navigator_quality: string \"good\", not a number"},
      {"[" + kDialogue + "," + kDialogue + "]", "$[1].idx: \"12\" stands at $[0] already"},
      {"[" + kDialogue, "the file ends too early"},
      {"", "the file is empty"},
  };
  for (const auto& [text, says] : cases) EXPECT_THAT(refusal_of(text), HasSubstr(says));
}

TEST(Dialogues, WhatJsonCannotSayIsNotWritten) {
  Dialogue dialogue;
  dialogue.target = "\xff";
  EXPECT_THROW(to_json(std::vector{dialogue}), ArgumentError);
  dialogue.target = "bed";
  dialogue.camera = "no JSON";
  EXPECT_THROW(to_json(std::vector{dialogue}), ArgumentError);
  dialogue.camera = "";
  dialogue.oracle.quality = std::numeric_limits<double>::infinity();
  EXPECT_THROW(to_json(std::vector{dialogue}), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
