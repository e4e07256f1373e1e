#include "enfilade/models/decisions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <variant>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/made_run.h"

namespace enfilade::models {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::FloatNear;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr const char* kGood =
    R"({"1_0": {"agent": "duet", "words": ["walk", "on"], "steps": [
  {"viewpoint": "v0", "heading": 1.5, "elevation": 0, "attention": [0.25, 0.75], "choices": [
    {"viewpoint": null, "probability": 0.1, "map": 0.2, "view": 0.05},
    {"viewpoint": "v1", "probability": 0.6, "map": 0.5, "view": 0.95},
    {"viewpoint": "v9", "probability": 0.3, "map": 0.3}], "chosen": 2, "way": ["v1", "v9"],
   "map_share": 0.625, "nodes": [{"viewpoint": "v0", "visited": true, "stop": 0.1},
    {"viewpoint": "v1", "visited": false}], "object": "66", "more": [1]},
  {"viewpoint": "v9", "heading": -0.0, "elevation": -0.5, "choices": [
    {"viewpoint": null, "probability": 1.0004}], "chosen": 0}]}})";

TEST(Decisions, ReadsStepsWithAndWithoutAMap) {
  const DecisionFile file = parse_decisions(kGood, "a.json");
  ASSERT_TRUE(file.contains("1_0"));
  const EpisodeDecisions& episode = file.at("1_0");
  EXPECT_EQ(episode.agent, "duet");
  EXPECT_THAT(episode.words, ElementsAre("walk", "on"));
  ASSERT_EQ(episode.steps.size(), 2U);
  const DecisionStep& step = episode.steps[0];
  EXPECT_EQ(step.viewpoint, "v0");
  EXPECT_THAT(step.attention, ElementsAre(0.25, 0.75));
  ASSERT_EQ(step.choices.size(), 3U);
  EXPECT_EQ(step.choices[0].viewpoint, "") << "stop";
  EXPECT_EQ(step.choices[1].view, 0.95);
  EXPECT_EQ(step.choices[2].viewpoint, "v9");
  EXPECT_EQ(step.choices[2].view, std::nullopt) << "it is not to be seen from here";
  EXPECT_EQ(step.chosen, 2U);
  EXPECT_THAT(step.way, ElementsAre("v1", "v9"));
  EXPECT_EQ(step.map_share, 0.625);
  ASSERT_EQ(step.nodes.size(), 2U);
  EXPECT_TRUE(step.nodes[0].visited);
  EXPECT_EQ(step.nodes[0].stop, 0.1);
  EXPECT_EQ(step.nodes[1].stop, std::nullopt);
  EXPECT_EQ(step.object, "66");
  EXPECT_THAT(episode.steps[1].nodes, IsEmpty());
  EXPECT_EQ(episode.steps[1].map_share, std::nullopt);
}

TEST(Decisions, AreWrittenAsTheyAreRead) {
  const DecisionFile read = parse_decisions(kGood, "a.json");
  const std::vector<std::pair<std::string, EpisodeDecisions>> episodes(read.begin(), read.end());
  const std::string written = decisions_json(episodes);
  EXPECT_EQ(written,
            "{\n\"1_0\":{\"agent\":\"duet\",\"words\":[\"walk\",\"on\"],\"steps\":["
            R"({"viewpoint":"v0","heading":1.5,"elevation":0,"attention":[0.25,0.75],"choices":[)"
            R"({"viewpoint":null,"probability":0.1,"map":0.2,"view":0.05},)"
            R"({"viewpoint":"v1","probability":0.6,"map":0.5,"view":0.95},)"
            R"({"viewpoint":"v9","probability":0.3,"map":0.3}],"chosen":2,"way":["v1","v9"],)"
            R"("map_share":0.625,"nodes":[{"viewpoint":"v0","visited":true,"stop":0.1},)"
            R"({"viewpoint":"v1","visited":false}],"object":"66"},)"
            R"({"viewpoint":"v9","heading":0,"elevation":-0.5,"choices":[)"
            R"({"viewpoint":null,"probability":1.0004}],"chosen":0}]})"
            "\n}\n");
  const DecisionFile again = parse_decisions(written, "b.json");
  EXPECT_EQ(decisions_json({{*again.begin()}}), written);
  EXPECT_EQ(decisions_json({}), "{\n}\n");
}

TEST(Decisions, AreToldFromAttention) {
  EXPECT_TRUE(std::holds_alternative<DecisionFile>(parse_recorded_split(kGood, "a.json")));
  const char* attention = R"({"1_0": {"words": ["a"], "steps": [{"action": "end",
    "attention": [1], "viewpoint": "v", "heading": 0, "elevation": 0}]}})";
  const RecordedSplit other = parse_recorded_split(attention, "a.json");
  ASSERT_TRUE(std::holds_alternative<AttentionFile>(other));
  EXPECT_EQ(std::get<AttentionFile>(other).size(), 1U);
  EXPECT_TRUE(std::holds_alternative<AttentionFile>(parse_recorded_split("{}", "a.json")));
  EXPECT_THROW((void)parse_recorded_split("[]", "a.json"), InvalidInput);
  EXPECT_THROW((void)parse_recorded_split("{", "a.json"), InvalidInput);
}

struct Bad {
  const char* json;
  const char* code;
  const char* where;
};

class DecisionFaults : public ::testing::TestWithParam<Bad> {};

TEST_P(DecisionFaults, AreNamedWithTheirPlace) {
  try {
    (void)parse_decisions(GetParam().json, "a.json");
    FAIL() << "was accepted";
  } catch (const InvalidInput& refused) {
    ASSERT_EQ(refused.diagnostics().size(), 1U);
    EXPECT_EQ(refused.diagnostics()[0].code, GetParam().code);
    EXPECT_THAT(refused.diagnostics()[0].where, HasSubstr(GetParam().where));
  }
}

// As object sets and results have them.
TEST(Decisions, ReadsObjectsWhoseNumbersAreBelowZero) {
  std::string text = kGood;
  text.replace(text.find("\"66\""), 4, "\"-1\"");
  const DecisionFile file = parse_decisions(text, "a.json");
  EXPECT_EQ(file.at("1_0").steps[0].object, "-1");
}

#define EN_STEP(fields)                                                       \
  R"({"1_0": {"agent": "duet", "words": ["a"], "steps": [{"viewpoint": "v",)" \
  R"( "heading": 0, "elevation": 0, )" fields "}]}}"
#define EN_STAYS R"("choices": [{"viewpoint": null, "probability": 1}], "chosen": 0, )"

INSTANTIATE_TEST_SUITE_P(
    All, DecisionFaults,
    ::testing::Values(
        Bad{"{", "not-json", "$"}, Bad{"[]", "not-an-object", "$"},
        Bad{R"({"1_0": {"words": [], "steps": []}})", "missing-field", "1_0"},
        Bad{R"({"1_0": {"agent": 2, "words": [], "steps": []}})", "not-a-string", "1_0.agent"},
        Bad{R"({"1_0": {"agent": "duet", "words": [1], "steps": []}})", "not-a-string", "words[0]"},
        Bad{R"({"1_0": {"agent": "duet", "words": [], "steps": {}}})", "not-an-array", "steps"},
        Bad{R"({"1_0": {"agent": "duet", "words": [], "steps": [3]}})", "not-an-object",
            "steps[0]"},
        Bad{EN_STEP(R"("chosen": 0)"), "missing-field", "steps[0]"},
        Bad{EN_STEP(R"("choices": [], "chosen": 0)"), "no-choice", "steps[0].choices"},
        Bad{EN_STEP(R"("choices": [{"viewpoint": "", "probability": 1}], "chosen": 0)"), "bad-id",
            "choices[0].viewpoint"},
        Bad{EN_STEP(R"("choices": [{"viewpoint": "w"}], "chosen": 0)"), "missing-field",
            "choices[0]"},
        Bad{EN_STEP(R"("choices": [{"viewpoint": "w", "probability": 1.5}], "chosen": 0)"),
            "bad-probability", "choices[0].probability"},
        Bad{EN_STEP(R"("choices": [{"viewpoint": "w", "probability": 1, "map": -1}], "chosen": 0)"),
            "bad-probability", "choices[0].map"},
        Bad{EN_STEP(R"("choices": [{"viewpoint": "w", "probability": 1, "view": null}],
                       "chosen": 0)"),
            "not-a-number", "choices[0].view"},
        Bad{EN_STEP(R"("choices": [{"viewpoint": "w", "probability": 1}], "chosen": 1)"),
            "bad-choice", "steps[0].chosen"},
        Bad{EN_STEP(R"("choices": [{"viewpoint": "w", "probability": 1}], "chosen": -1)"),
            "bad-choice", "steps[0].chosen"},
        Bad{EN_STEP(EN_STAYS R"("attention": [0.5, 0.5])"), "attention-size", "steps[0].attention"},
        Bad{EN_STEP(EN_STAYS R"("attention": [2])"), "bad-probability", "attention[0]"},
        Bad{EN_STEP(EN_STAYS R"("map_share": 1.5)"), "bad-probability", "map_share"},
        Bad{EN_STEP(EN_STAYS R"("way": "v")"), "not-an-array", "way"},
        Bad{EN_STEP(EN_STAYS R"("nodes": [{"viewpoint": "v"}])"), "missing-field", "nodes[0]"},
        Bad{EN_STEP(EN_STAYS R"("nodes": [{"viewpoint": "v", "visited": 1}])"), "not-a-boolean",
            "nodes[0].visited"},
        Bad{EN_STEP(EN_STAYS R"("nodes": [{"viewpoint": "v", "visited": true, "stop": 3}])"),
            "bad-probability", "nodes[0].stop"},
        Bad{EN_STEP(EN_STAYS R"("object": 66)"), "not-a-string", "object"},
        Bad{EN_STEP(EN_STAYS R"("object": "-x")"), "bad-id", "object"}));

TEST(DecisionRecorder, MakesProbabilitiesOfLogits) {
  const float never = -std::numeric_limits<float>::infinity();
  const std::vector<float> logits{never, 2, 2 + std::log(3.0F)};
  EXPECT_THAT(probabilities(logits),
              ElementsAre(0, FloatNear(0.25F, 1e-6F), FloatNear(0.75F, 1e-6F)));
  EXPECT_THAT(probabilities({}), IsEmpty());
}

// Episodes 1_0 to 2_2 of the made-up row of viewpoints; each goes from v0 to v1 and stops.
class Recorder : public ::testing::Test {
 protected:
  void SetUp() override {
    graphs_ = graph::GraphSet::open(made_.data() / "connectivity");
    episodes_ = tasks::make_episodes(
        tasks::load_annotations(made_.data() / "r2r/R2R_val_unseen.json", "val_unseen"), graphs_);
    for (std::size_t i = 0; i < episodes_.episodes.size(); ++i) {
      tasks::Trajectory walk;
      walk.episode = i;
      walk.points = {{ViewpointIndex(0), {}, {}}, {ViewpointIndex(1), {}, {}}};
      walks_.push_back(walk);
    }
  }
  report::testing::MadeRun made_;
  std::shared_ptr<const graph::GraphSet> graphs_;
  tasks::EpisodeSet episodes_;
  std::vector<tasks::Trajectory> walks_;
};

TEST_F(Recorder, WritesWhatWasChosenByName) {
  DecisionRecorder recorder(AgentKind::kDuet, episodes_.episodes.size());
  for (std::size_t i = 0; i < episodes_.episodes.size(); ++i) {
    recorder.read(i, {"walk", "on"});
    recorder.add(i, {.viewpoint = ViewpointIndex(0),
                     .heading = Radians(1.5),
                     .elevation = Radians(0),
                     .attention = {0.5F, 0.5F},
                     .choices = {{.viewpoint = {}, .probability = 0.25F, .map = 0.5F},
                                 {.viewpoint = ViewpointIndex(1), .probability = 0.75F}},
                     .chosen = 1,
                     .way = {ViewpointIndex(1)},
                     .map_share = 0.5F,
                     .nodes = {{ViewpointIndex(0), true, 0.25F}, {ViewpointIndex(1), false}}});
  }
  EXPECT_EQ(recorder.episode(3, episodes_).steps.size(), 1U);
  const DecisionFile read = parse_decisions(recorder.text(episodes_, walks_), "recorded");
  EXPECT_EQ(read.size(), 6U);
  const EpisodeDecisions& episode = read.at("2_2");
  EXPECT_EQ(episode.agent, "duet");
  ASSERT_EQ(episode.steps.size(), 1U);
  const DecisionStep& step = episode.steps[0];
  EXPECT_EQ(step.viewpoint, "v0");
  EXPECT_EQ(step.heading, 1.5);
  EXPECT_THAT(step.attention, ElementsAre(0.5, 0.5));
  EXPECT_EQ(step.choices.at(0).viewpoint, "");
  EXPECT_EQ(step.choices.at(0).map, 0.5);
  EXPECT_EQ(step.choices.at(1).viewpoint, "v1");
  EXPECT_THAT(step.way, ElementsAre("v1"));
  EXPECT_EQ(step.nodes.at(0).stop, 0.25);
  EXPECT_FALSE(step.nodes.at(1).visited);
}

TEST_F(Recorder, ShowsTheFirstTheBestAndTheWorst) {
  // Path 1 is 8 m long, path 2 is 6 m: from v1 the goals are 6 m and 4 m away.
  walks_[5].points.push_back({ViewpointIndex(2), {}, {}});
  walks_[5].points.push_back({ViewpointIndex(3), {}, {}});  // arrives
  EXPECT_THAT(shown_episodes(walks_, episodes_, 3), ElementsAre(0, 1, 2, 5));
  EXPECT_THAT(shown_episodes(walks_, episodes_, 100), ElementsAre(0, 1, 2, 3, 4, 5));
}

}  // namespace EN_UNIT
}  // namespace enfilade::models
