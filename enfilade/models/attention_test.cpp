#include "enfilade/models/decisions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"

namespace enfilade::models {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

constexpr const char* kGood = R"({"1_0": {"words": ["walk", "on"], "steps": [
  {"action": "forward", "attention": [0.25, 0.75], "viewpoint": "v0", "heading": 1.5,
   "elevation": 0, "more": [1]},
  {"action": "end", "attention": [1, 0], "viewpoint": "v1", "heading": 1.5, "elevation": -0.5}]}})";

TEST(Attention, ReadsWordsAndSteps) {
  const auto file = std::get<AttentionFile>(parse_recorded_split(kGood, "a.json"));
  ASSERT_TRUE(file.contains("1_0"));
  const EpisodeAttention& episode = file.at("1_0");
  EXPECT_THAT(episode.words, ElementsAre("walk", "on"));
  ASSERT_EQ(episode.steps.size(), 2U);
  EXPECT_EQ(episode.steps[0].action, "forward");
  EXPECT_THAT(episode.steps[0].attention, ElementsAre(0.25, 0.75));
  EXPECT_EQ(episode.steps[1].viewpoint, "v1");
  EXPECT_EQ(episode.steps[1].elevation, -0.5);
}

TEST(Attention, IsWrittenAsItIsRead) {
  const auto read = std::get<AttentionFile>(parse_recorded_split(kGood, "a.json"));
  const std::vector<std::pair<std::string, EpisodeAttention>> episodes(read.begin(), read.end());
  EXPECT_EQ(attention_json(episodes),
            "{\n\"1_0\":{\"words\":[\"walk\",\"on\"],\"steps\":["
            R"({"action":"forward","attention":[0.2500,0.7500],"viewpoint":"v0","heading":1.5,)"
            R"("elevation":0},)"
            R"({"action":"end","attention":[1.0000,0.0000],"viewpoint":"v1","heading":1.5,)"
            R"("elevation":-0.5}]})"
            "\n}\n");
  EXPECT_EQ(attention_json({}), "{\n}\n");
}

struct Bad {
  const char* json;
  const char* code;
  const char* where;
};

class AttentionFaults : public ::testing::TestWithParam<Bad> {};

TEST_P(AttentionFaults, AreNamedWithTheirPlace) {
  try {
    (void)parse_recorded_split(GetParam().json, "a.json");
    FAIL() << "was accepted";
  } catch (const InvalidInput& refused) {
    ASSERT_FALSE(refused.diagnostics().empty());
    EXPECT_EQ(refused.diagnostics()[0].code, GetParam().code);
    EXPECT_THAT(refused.diagnostics()[0].where, HasSubstr(GetParam().where));
  }
}

INSTANTIATE_TEST_SUITE_P(
    All, AttentionFaults,
    ::testing::Values(
        Bad{"{", "not-json", "$"}, Bad{"[]", "not-an-object", "$"},
        Bad{R"({"1_0": {"words": []}})", "missing-field", "1_0"},
        Bad{R"({"1_0": {"words": ["a"], "steps": [{"action": "end", "attention": [0.5, 0.5],
            "viewpoint": "v", "heading": 0, "elevation": 0}]}})",
            "attention-size", "steps[0].attention"},
        Bad{R"({"1_0": {"words": ["a"], "steps": [{"action": "end", "attention": [1.5],
            "viewpoint": "v", "heading": 0, "elevation": 0}]}})",
            "bad-weight", "attention[0]"}));

}  // namespace EN_UNIT
}  // namespace enfilade::models
