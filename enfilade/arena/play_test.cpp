#include "enfilade/arena/play.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "tests/support/grid_world.h"
#include "tests/support/refusal.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::arena {
namespace EN_UNIT {

using arena::testing::episodes;
using nlohmann::json;
using ::testing::HasSubstr;

class PlayTest : public ::testing::Test {
 protected:
  PlayTest() : folder_("play"), episodes_(episodes(tasks::Task::kR2r, 1)) {}

  std::unique_ptr<Play> play(const char* prompt = "text", PlayConfig config = {}) {
    if (config.episodes.empty()) config.episodes = {0, 1};
    return std::make_unique<Play>(std::make_unique<GraphWorld>(episodes_), ViewSources(),
                                  Prompt::named(prompt), std::move(config));
  }

  tests::TemporaryFolder folder_;
  std::shared_ptr<const tasks::EpisodeSet> episodes_;
};

TEST_F(PlayTest, EpisodesAreWalkedInTheirOrder) {
  const auto walked = play();
  EXPECT_EQ(walked->session(), nullptr);
  ASSERT_TRUE(walked->begin());
  EXPECT_THAT(walked->start_text(), HasSubstr("Go to the desk."));
  EXPECT_THAT(walked->step_text(), HasSubstr("You are at place A"));
  EXPECT_TRUE(walked->draw().empty());
  PlayOutcome outcome =
      walked->call(walked->read(R"({"name": "go_to", "arguments": {"place": "B"}})"));
  EXPECT_TRUE(outcome.carried_out);
  EXPECT_FALSE(outcome.ending);
  EXPECT_THAT(outcome.told, HasSubstr("You went to B"));
  outcome = walked->call(walked->read(R"({"name": "stop", "arguments": "{}"})"));
  EXPECT_EQ(outcome.ending, Ending::kStopped);
  EXPECT_EQ(walked->session(), nullptr);
  EXPECT_EQ(walked->done(), 1U);
  ASSERT_TRUE(walked->begin());
  EXPECT_EQ(walked->session()->episode(), 1U);
  walked->call(read_call("stop", {}));
  EXPECT_FALSE(walked->begin());
  const json results = json::parse(walked->results());
  ASSERT_EQ(results.size(), 2U);
  EXPECT_EQ(results[0].at("trajectory").size(), 2U);
}

TEST_F(PlayTest, WhatCannotBeReadIsToldAndDoesNothing) {
  const auto walked = play("text", {.episodes = {0}, .limits = {.steps = 9, .mistakes = 3}});
  walked->begin();
  PlayOutcome outcome;
  for (const char* answer : {"I stop here.", "[1]", R"({"arguments": {}})"}) {
    ASSERT_FALSE(outcome.ending) << answer;
    outcome = walked->call(walked->read(answer));
    EXPECT_FALSE(outcome.carried_out) << answer;
    EXPECT_THAT(outcome.told, HasSubstr("the answer is no JSON object")) << answer;
  }
  EXPECT_EQ(outcome.ending, Ending::kMistakes);
  EXPECT_EQ(json::parse(walked->results())[0].at("trajectory").size(), 1U);
}

TEST_F(PlayTest, AnEpisodeThatIsGivenUpBeginsAgain) {
  const auto walked = play();
  walked->begin();
  walked->call(read_call("go_to", R"({"place": "B"})"));
  ASSERT_TRUE(walked->begin());
  EXPECT_EQ(walked->session()->episode(), 0U);
  EXPECT_EQ(walked->session()->observation().here, "A");
}

TEST_F(PlayTest, AnEpisodeIsWalkedAnewAndTheLastWalkCounts) {
  const auto walked = play();
  walked->begin_at(1);
  walked->call(read_call("stop", {}));
  walked->begin_at(1);
  const std::string place = walked->session()->observation().places[0].name;
  walked->call(read_call("go_to", json{{"place", place}}.dump()));
  walked->call(read_call("stop", {}));
  const json results = json::parse(walked->results());
  ASSERT_EQ(results.size(), 1U);
  EXPECT_EQ(results[0].at("trajectory").size(), 2U);
  EXPECT_EQ(walked->result(1), walked->results());
  EXPECT_THAT([&] { walked->result(0); },
              ::testing::ThrowsMessage<ArgumentError>(HasSubstr("has not been walked")));
  EXPECT_THAT([&] { walked->begin_at(2); },
              ::testing::ThrowsMessage<ArgumentError>(HasSubstr("episode: 2 is not one of")));
}

TEST_F(PlayTest, PromptsOfTextRememberWhatWasDone) {
  const auto walked = play("navgpt");
  walked->begin();
  EXPECT_EQ(walked->answers(), Answers::kText);
  walked->call(walked->read("It leads east.\nAction: go_to B"));
  EXPECT_THAT(walked->step_text(), HasSubstr("It leads east."));
}

TEST_F(PlayTest, AFolderGoesOnAndHasWhatMemoryHas) {
  const auto in_memory = play();
  const auto in_folder = play("text", {.episodes = {0, 1}, .folder = folder_.path()});
  for (Play* one : {in_memory.get(), in_folder.get()}) {
    one->begin();
    one->call(read_call("go_to", R"({"place": "C"})"));
    one->call(read_call("stop", {}));
  }
  EXPECT_EQ(json::parse(in_folder->results()), json::parse(in_memory->results()));
  EXPECT_EQ(in_folder->results(), read_file(folder_.path() / "results.json"));
}

TEST_F(PlayTest, AFolderIsContinuedByTheNextProcess) {
  {
    const auto first = play("text", {.episodes = {0, 1}, .folder = folder_.path()});
    first->begin();
    first->call(read_call("stop", {}));
  }
  const auto second = play("text", {.episodes = {0, 1}, .folder = folder_.path()});
  EXPECT_EQ(second->done(), 1U);
  ASSERT_TRUE(second->begin());
  EXPECT_EQ(second->session()->episode(), 1U);
}

TEST_F(PlayTest, ValuesOutOfRangeAreRefused) {
  EXPECT_THAT([&] { play("text", {.episodes = {9}}); },
              ::testing::ThrowsMessage<ArgumentError>(HasSubstr("episode: 9; there are")));
  EXPECT_THAT([&] { play("marks"); },
              ::testing::ThrowsMessage<ArgumentError>(HasSubstr("no data set")));
  EXPECT_THAT([&] { play("text", {.episodes = {0}, .limits = {.steps = 0}}); },
              ::testing::ThrowsMessage<ArgumentError>(HasSubstr("steps")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
