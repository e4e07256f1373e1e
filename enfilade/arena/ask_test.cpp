// A stand-in of a language model over real sockets: walks, faults, resumption, replay, what it
// costs.
#include "enfilade/arena/ask.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "enfilade/agents/continuous_run.h"
#include "enfilade/agents/run.h"
#include "enfilade/arena/stand_in.h"
#include "enfilade/arena/world.h"
#include "enfilade/core/enum_names.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/gzip.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"
#include "tests/support/grid_world.h"
#include "tests/support/refusal.h"
#include "tests/support/room_world.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::arena {
namespace EN_UNIT {

using arena::testing::episodes;
using ::testing::HasSubstr;
using ::testing::Not;
using tests::refusal;
namespace fs = std::filesystem;

class Ask : public ::testing::Test {
 protected:
  Ask() : folder_("ask"), episodes_(episodes(tasks::Task::kR2r, 8)) {
    which_.resize(episodes_->episodes.size());
    std::iota(which_.begin(), which_.end(), 0U);
    config_.chat.model = "stand-in";
    config_.parallel = 4;
    config_.first_wait = 0.01;
  }

  std::unique_ptr<World> world() const { return std::make_unique<GraphWorld>(episodes_); }
  AskReport run(Endpoint* endpoint, const std::string& name = "run",
                const std::string& cache = "cache", const std::string& prompt = "text") {
    AnswerCache answers(folder_.path() / cache);
    return ask(*world(), {}, which_, Prompt::named(prompt), config_, endpoint, answers,
               folder_.path() / name);
  }
  AskReport run(const StandIn& stand_in, const std::string& name = "run") {
    const auto endpoint = make_http_endpoint({.url = stand_in.url(), .timeout = 30});
    return run(endpoint.get(), name);
  }
  std::string results(const std::string& name = "run") const {
    return read_file(folder_.path() / name / "results.json");
  }
  double success(const std::string& name = "run") const {
    const auto parsed = tasks::parse_results(results(name), "results", *episodes_);
    return tasks::compute_score(parsed.trajectories, *episodes_).mean("success").mean;
  }
  /// All files that a run has written, by name.
  std::map<std::string, std::string> files(const std::string& name) const {
    std::map<std::string, std::string> all;
    for (const auto& one : fs::recursive_directory_iterator(folder_.path() / name)) {
      if (one.is_regular_file()) {
        all[fs::relative(one.path(), folder_.path() / name).string()] = read_file(one.path());
      }
    }
    return all;
  }

  tests::TemporaryFolder folder_;
  std::shared_ptr<const tasks::EpisodeSet> episodes_;
  std::vector<std::size_t> which_;
  AskConfig config_;
};

TEST_F(Ask, TheOracleReachesEveryGoalInEveryFormOfAnswers) {
  const StandIn stand_in(world(), {});
  for (const Answers answers : {Answers::kTools, Answers::kJson, Answers::kText}) {
    config_.answers = answers;
    const std::string name(enum_name(answers));
    const AskReport report = run(stand_in, name);
    EXPECT_EQ(report.done, which_.size());
    EXPECT_EQ(report.mistakes, 0U);
    EXPECT_EQ(report.endings.at(Ending::kStopped), which_.size());
    EXPECT_EQ(success(name), 1) << name;
    EXPECT_EQ(results(name), results("tools"));
  }
  for (const std::string& prompt : Prompt::names()) {
    if (Prompt::named(prompt).pictures() != PictureKind::kNone) continue;
    config_.answers.reset();
    const auto endpoint = make_http_endpoint({.url = stand_in.url()});
    EXPECT_EQ(run(endpoint.get(), "of-" + prompt, "cache", prompt).done, which_.size());
    EXPECT_EQ(results("of-" + prompt), results("tools")) << prompt;
  }
}

TEST_F(Ask, AServerWithoutToolsIsAskedForJson) {
  const StandIn plain(world(), {});
  run(plain, "plain");
  const StandIn without(world(), {.with_tools = false});
  const auto endpoint = make_http_endpoint({.url = without.url()});
  const AskReport report = run(endpoint.get(), "json", "other-cache");
  EXPECT_EQ(report.answers, Answers::kJson);
  EXPECT_EQ(report.done, which_.size());
  EXPECT_EQ(results("json"), results("plain"));
  EXPECT_EQ(without.answers(), report.ledger.answers) << "the first answer counts, and once";
  // The folder says how the run asks: nobody is asked again, and nothing else is.
  EXPECT_EQ(run(endpoint.get(), "json", "other-cache").answers, Answers::kJson);
  config_.answers = Answers::kTools;
  EXPECT_THAT(refusal<InvalidInput>([&] { run(endpoint.get(), "tools", "third-cache"); }),
              HasSubstr("no tools here"));
}

TEST_F(Ask, RandomIsTheAgentsWalk) {
  const StandIn stand_in(world(), {.rule = Rule::kRandom, .seed = 3});
  run(stand_in);
  const auto parsed = tasks::parse_results(results(), "results", *episodes_);
  const auto agent = agents::make_agent("random");
  const auto walked = agents::run_agent(*agent, *episodes_, {.seed = 3});
  for (std::size_t e = 0; e < walked.size(); ++e) {
    EXPECT_EQ(parsed.trajectories[e].points.back().viewpoint, walked[e].points.back().viewpoint);
  }
}

TEST_F(Ask, ReverieAsksForTheObject) {
  episodes_ = episodes(tasks::Task::kReverie);
  which_ = {0};
  const StandIn stand_in(world(), {});
  EXPECT_EQ(run(stand_in).done, 1U);
  EXPECT_THAT(results(), HasSubstr("\"predObjId\":7"));
}

// Every form of answers, and of results files; the goal is 4 m away, so stopping early would show.
TEST_F(Ask, MovesOnTheFloor) {
  for (const char* task : {"r2r-ce", "rxr-ce"}) {
    const FloorWorld room = testing::room(4);
    auto named = std::make_shared<tasks::ContinuousEpisodes>(*room.episodes().continuous());
    for (tasks::ContinuousEpisode& one : named->episodes) one.instruction.id = one.id;
    const FloorWorld world(tasks::Split(tasks::benchmark(task), named), room.buildings());
    const StandIn stand_in(world.another(), {});
    const auto endpoint = make_http_endpoint({.url = stand_in.url()});
    config_.limits = usual_limits(task);
    AnswerCache cache(folder_.path() / task / "cache");
    std::string first;
    for (const char* prompt : {"text", "navgpt"}) {
      const fs::path run = folder_.path() / task / prompt;
      const AskReport report = ask(world, {}, {0, 1, 2, 3, 4}, Prompt::named(prompt), config_,
                                   endpoint.get(), cache, run);
      EXPECT_EQ(report.done, 5U);
      EXPECT_EQ(report.mistakes, 0U);
      EXPECT_EQ(report.endings.at(Ending::kStopped), 5U);
      const auto walks = tasks::load_continuous_results(run / "results.json", *named);
      for (const auto& score : agents::score_continuous_walks(walks, *named, *room.buildings())) {
        EXPECT_EQ(score.success, 1);
        EXPECT_LT(score.distance_to_goal, 0.3);
      }
      const std::string results = read_file(run / "results.json");
      if (first.empty()) first = results;
      EXPECT_EQ(results, first) << prompt;
      const AskReport again = ask(world, {}, {0, 1, 2, 3, 4}, Prompt::named(prompt), config_,
                                  nullptr, cache, folder_.path() / task / "replayed" / prompt);
      EXPECT_EQ(again.done, 5U);
    }
  }
}

TEST_F(Ask, WhatFailsIsAskedAgainAndMistakesAreTold) {
  const StandIn plain(world(), {});
  run(plain, "plain");
  const StandIn failing(
      world(), {.faults = {StandInFault::kServerError, StandInFault::kRateLimit,
                           StandInFault::kCutOff, StandInFault::kNotJson, StandInFault::kNoChoice},
                .one_in = 2});
  const auto endpoint = make_http_endpoint({.url = failing.url()});
  const AskReport report = run(endpoint.get(), "failing", "other-cache");
  EXPECT_GT(failing.requests(), failing.answers());
  EXPECT_EQ(static_cast<std::size_t>(report.ledger.attempts), failing.requests());
  EXPECT_EQ(report.done, which_.size());
  EXPECT_EQ(files("failing"), files("plain"));  // nobody sees that something failed

  const StandIn clumsy(
      world(), {.faults = {StandInFault::kUnknownPlace, StandInFault::kNoCall}, .one_in = 3});
  const auto other = make_http_endpoint({.url = clumsy.url()});
  const AskReport made = run(other.get(), "clumsy", "clumsy-cache");
  EXPECT_EQ(made.done, which_.size());
  EXPECT_GT(made.mistakes, 0U);
  EXPECT_EQ(success("clumsy"), 1);  // a mistake neither moves nor stops
}

TEST_F(Ask, SilenceIsNotWaitedForForEver) {
  which_ = {0, 1};
  const StandIn silent(world(), {.faults = {StandInFault::kSilence}, .one_in = 1, .silence = 0.6});
  const auto endpoint = make_http_endpoint({.url = silent.url(), .timeout = 0.2});
  EXPECT_EQ(run(endpoint.get()).done, 2U);
}

TEST_F(Ask, AModelThatNeverStopsIsStopped) {
  config_.limits.steps = 5;
  const StandIn stand_in(world(), {.rule = Rule::kFirst});
  const AskReport report = run(stand_in);
  EXPECT_EQ(report.endings.at(Ending::kOutOfSteps), which_.size());
  EXPECT_EQ(report.ledger.answers, 5 * which_.size());
}

TEST_F(Ask, IsReplayedFromTheCacheToTheBit) {
  const StandIn stand_in(world(), {});
  const AskReport first = run(stand_in, "first");
  const AskReport replayed = run(nullptr, "second");
  EXPECT_EQ(files("first"), files("second"));
  EXPECT_EQ(replayed.done, which_.size());
  EXPECT_EQ(replayed.ledger.prompt_tokens, first.ledger.prompt_tokens);
  EXPECT_EQ(replayed.ledger.attempts, first.ledger.attempts);
  EXPECT_EQ(stand_in.requests(), first.ledger.answers);
  config_.parallel = 1;
  run(nullptr, "third");
  EXPECT_EQ(files("first"), files("third"));
  // What was never asked cannot be replayed.
  config_.chat.model = "another";
  const AskReport missing = run(nullptr, "fourth");
  EXPECT_EQ(missing.done, 0U);
  EXPECT_EQ(missing.given_up.size(), which_.size());
  EXPECT_THAT(missing.given_up.front(), HasSubstr("is not in the cache"));
}

TEST_F(Ask, ARunGoesOnAndAsksNothingTwice) {
  const StandIn stand_in(world(), {});
  const auto endpoint = make_http_endpoint({.url = stand_in.url()});
  config_.most_tokens = 3000;
  config_.parallel = 2;
  const AskReport part = run(endpoint.get());
  EXPECT_LT(part.done, which_.size());
  EXPECT_THAT(part.given_up.front(), HasSubstr("tokens were used"));
  config_.most_tokens.reset();
  const AskReport whole = run(endpoint.get());
  EXPECT_EQ(whole.done, which_.size());
  EXPECT_TRUE(whole.given_up.empty());
  EXPECT_EQ(stand_in.requests(), whole.ledger.answers);
  run(nullptr, "again");
  EXPECT_EQ(files("again"), files("run"));
}

TEST_F(Ask, AnotherRunsFolderIsRefused) {
  const StandIn stand_in(world(), {});
  run(stand_in);
  config_.limits.steps = 7;
  EXPECT_THAT(refusal<InvalidInput>([&] { run(stand_in); }),
              HasSubstr("$.steps: 30, and 7 is asked for"));
  config_.limits.steps = 30;
  config_.chat.temperature = 0.5;
  EXPECT_THAT(refusal<InvalidInput>([&] { run(stand_in); }), HasSubstr("$.temperature"));
}

TEST_F(Ask, TheKeyIsWrittenNowhere) {
  const std::string key = "sk-verysecret123";
  const StandIn stand_in(world(), {.key = key});
  const auto good = make_http_endpoint({.url = stand_in.url(), .key = key});
  EXPECT_EQ(run(good.get()).done, which_.size());
  for (const auto& [name, content] : files(".")) {
    EXPECT_THAT(content, Not(HasSubstr("verysecret"))) << name;
  }
  // The server repeats what it was sent.
  const auto wrong = make_http_endpoint({.url = stand_in.url(), .key = "sk-wrongsecret"});
  config_.chat.model = "another";
  const std::string said = refusal<InvalidInput>([&] { run(wrong.get(), "wrong"); });
  EXPECT_THAT(said, HasSubstr("status 401"));
  EXPECT_THAT(said, Not(HasSubstr("wrongsecret")));
}

TEST_F(Ask, BadEndpointsAreNamed) {
  const auto fault = [](const HttpEndpointConfig& config) {
    return refusal<ArgumentError>([&] { make_http_endpoint(config); });
  };
  EXPECT_THAT(fault({.url = "127.0.0.1:8000"}), HasSubstr("not http://... or https://..."));
  EXPECT_THAT(fault({.url = "ftp://x"}), HasSubstr("not http"));
  EXPECT_THAT(fault({.url = "http://user:pass@x/v1"}), Not(HasSubstr("pass@")));
  EXPECT_THAT(fault({.url = "http://x/v1?key=abc"}), Not(HasSubstr("abc")));
  EXPECT_THAT(fault({.url = "http://"}), HasSubstr("an address"));
  EXPECT_THAT(fault({.url = "http://x", .key = "a\nb"}), Not(HasSubstr("a\nb")));
  EXPECT_THAT(fault({.url = "http://x", .timeout = 0}), HasSubstr("timeout: 0"));
  const auto nobody = make_http_endpoint({.url = "http://127.0.0.1:9/v1", .timeout = 1});
  config_.attempts = 2;
  which_ = {0};
  const AskReport report = run(nobody.get());
  EXPECT_EQ(report.done, 0U);
  EXPECT_THAT(report.given_up.front(), HasSubstr("no answer in 2 attempts"));
}

TEST_F(Ask, ManyRequestsAreInFlight) {
  episodes_ = episodes(tasks::Task::kR2r, 40);
  which_.resize(episodes_->episodes.size());
  std::iota(which_.begin(), which_.end(), 0U);
  config_.parallel = 32;
  const StandIn slow(world(), {.faults = {StandInFault::kSilence}, .one_in = 1, .silence = 0.3});
  run(slow);
  EXPECT_GE(slow.most_at_once(), 30U);
}

TEST_F(Ask, PricesMakeMoney) {
  const fs::path file = folder_.path() / "prices.json";
  write_file_atomically(file, R"({"m": {"prompt": 2.5, "answer": 10}})");
  const Price price = load_prices(file).at("m");
  Ledger ledger;
  ledger.prompt_tokens = 2'000'000;
  ledger.answer_tokens = 100'000;
  EXPECT_DOUBLE_EQ(money_of(ledger, price), 6);
  const std::string marked = "\xef\xbb\xbf" + read_file(file);
  write_file_atomically(file, marked);
  EXPECT_EQ(load_prices(file).at("m").answer, 10) << "behind a byte-order mark";
  write_file_atomically(file.string() + ".gz", gzip(marked, 6));
  fs::remove(file);
  EXPECT_EQ(load_prices(file).at("m").answer, 10) << "packed";
  write_file_atomically(file, R"({"m": {"prompt": -1, "answer": 10}})");
  EXPECT_THAT(refusal<InvalidInput>([&] { load_prices(file); }), HasSubstr("$.m.prompt"));
  write_file_atomically(file, "[]");
  EXPECT_THAT(refusal<InvalidInput>([&] { load_prices(file); }), HasSubstr("bad-price"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::arena
