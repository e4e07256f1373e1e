// What runs of the arena come to: outcomes, measures, comparisons and the model's pictures, over
// real sockets. Nothing of it where goals are hidden.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/bootstrap.h"
#include "enfilade/tasks/score_table.h"
#include "enfilade/tasks/split.h"
#include "tests/support/asked_runs.h"
#include "tests/support/base64_text.h"
#include "tests/support/served_benchmarks.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::kScript;
using ::testing::Not;
using testing::Script;
namespace fs = std::filesystem;

const std::vector<std::string> kStay{"Action: stop"};

class RunMeasuresTest : public testing::AskedRuns {
 protected:
  /// As `enfilade ask` and `enfilade score` score a run.
  tasks::ScoreTable score(const fs::path& folder, tasks::Task task = tasks::Task::kR2r,
                          const std::string& split = "val_seen") {
    const tasks::Split all(episodes(split, task));
    tasks::Trajectories results =
        tasks::load_trajectories(folder / "results.json", all, tasks::Coverage::kPart);
    const tasks::Split part = tasks::part_of(all, results);
    return tasks::compute_score(std::get<std::vector<tasks::Trajectory>>(results),
                                *part.on_graph());
  }
  std::vector<std::string> listed(const std::string& path) {
    std::vector<std::string> ids;
    const json list = get(path).at("list");
    for (const json& one : list) {
      ids.push_back(one.at("episode").get<std::string>());
    }
    return ids;
  }
};

TEST_F(RunMeasuresTest, ARunHasTheMeansOfItsScorer) {
  const fs::path folder = ask("run");
  const tasks::ScoreTable table = score(folder);
  const json measures = get("/run/measures");
  EXPECT_EQ(measures.at("run"), "run");
  EXPECT_EQ(measures.at("outcomes"), true);
  EXPECT_EQ(measures.at("ended"), 6);
  EXPECT_EQ(measures.at("scored"), 6);
  EXPECT_EQ(measures.at("unanswered"), 0);
  EXPECT_FALSE(measures.contains("seconds"));
  ASSERT_EQ(measures.at("scores").size(), table.scorer->columns.size());
  for (const json& one : measures["scores"]) {
    const auto name = one.at("name").get<std::string>();
    const tasks::Measure* measure = tasks::find_measure(table.scorer->columns, name);
    ASSERT_NE(measure, nullptr);
    EXPECT_EQ(one.at("short"), measure->column);
    EXPECT_DOUBLE_EQ(one.at("mean").get<double>(), table.mean(name).mean / measure->whole) << name;
  }
  std::size_t successes = 0;
  const json list = get("/run").at("list");
  for (const json& one : list) {
    const auto found = std::ranges::find(table.ids, one.at("episode").get<std::string>());
    ASSERT_NE(found, table.ids.end());
    const auto k = static_cast<std::size_t>(found - table.ids.begin());
    EXPECT_EQ(one.at("success"), table.value(k, "success") == 1);
    EXPECT_DOUBLE_EQ(one.at("spl").get<double>(), table.value(k, "spl"));
    EXPECT_DOUBLE_EQ(one.at("nav_error").get<double>(), table.value(k, "nav_error"));
    successes += one["success"].get<bool>() ? 1 : 0;
  }
  EXPECT_GT(successes, 0U);
}

TEST_F(RunMeasuresTest, AnEpisodeSaysWhatCameOfIt) {
  ask("run");
  ask("stay", kStay);
  const json good = get("/run/episodes/1_0").at("outcome");
  EXPECT_EQ(good.at("success"), true);
  EXPECT_DOUBLE_EQ(good.at("error").get<double>(), 1);
  EXPECT_DOUBLE_EQ(good.at("spl").get<double>(), 1);
  EXPECT_EQ(good.at("path"), (json{"v0", "v1", "v2", "v3"}));
  const json bad = get("/stay/episodes/1_0").at("outcome");
  EXPECT_EQ(bad.at("success"), false);
  EXPECT_DOUBLE_EQ(bad.at("error").get<double>(), 3);
  EXPECT_EQ(bad.at("spl"), 0);
}

TEST_F(RunMeasuresTest, AllBenchmarksAreScoredByTheirOwnScorer) {
  const testing::HiddenThings goals;
  testing::write_benchmarks(served_.root(), goals, true);  // the goals are in the data set
  served_.restart_with(R"({"name": "open", "split": "val_seen"})");
  for (const tasks::Task task : testing::kOtherTasks) {
    if (task == tasks::Task::kR2rBack || task == tasks::Task::kSoon) continue;  // not walked by ask
    SCOPED_TRACE(tasks::benchmark(task).name);
    const std::string name(tasks::benchmark(task).name);
    const bool named = task == tasks::Task::kReverie;
    const fs::path folder =
        ask(name, {"Action: go_to B", named ? "Action: answer 1" : "Action: stop"}, "test", task);
    const json measures = get("/" + name + "/measures");
    const auto count = get("/" + name).at("episodes").get<std::size_t>();
    EXPECT_EQ(measures.at("scored"), count);
    const tasks::ScoreTable table = score(folder, task, "test");
    EXPECT_EQ(table.episodes, count);
    for (const json& one : measures.at("scores")) {
      const auto column = one.at("name").get<std::string>();
      const tasks::Measure* measure = tasks::find_measure(table.scorer->columns, column);
      ASSERT_NE(measure, nullptr);
      const double mean = table.mean(column).mean / measure->whole;
      if (one.at("mean").is_null()) {
        EXPECT_FALSE(std::isfinite(mean)) << column;
      } else {
        EXPECT_NEAR(one.at("mean").get<double>(), mean, 1e-12) << column;
      }
    }
    EXPECT_TRUE(get("/" + name).at("list").at(0).contains("success"));
  }
}

TEST_F(RunMeasuresTest, OnlyWhatIsThereCounts) {
  const fs::path folder = ask("run");
  ask("stay", kStay);
  fs::remove(folder / "transcripts/3_0.jsonl");
  fs::remove(folder / "transcripts/3_1.jsonl");
  fs::resize_file(folder / "transcripts/2_0.jsonl", 10);
  const json measures = get("/run/measures");
  EXPECT_EQ(measures.at("episodes"), 4);
  EXPECT_EQ(measures.at("ended"), 3);
  EXPECT_EQ(measures.at("scored"), 3);
  // A file that is written anew is read anew.
  EXPECT_EQ(get("/run").at("list").at(0).at("success"), true);
  write_file_atomically(folder / "transcripts/1_0.jsonl",
                        read_file(runs_.path() / "stay/transcripts/1_0.jsonl"));
  EXPECT_EQ(get("/run").at("list").at(0).at("success"), false);
  // A result of another episode is no outcome.
  change(folder / "transcripts/1_1.jsonl", R"("instr_id":"1_1")", R"("instr_id":"2_1")");
  EXPECT_FALSE(get("/run").at("list").at(1).contains("success"));
  EXPECT_FALSE(get("/run/episodes/1_1").contains("outcome"));
  EXPECT_EQ(get("/run/measures").at("scored"), 2);
  // Nor is one of an episode with another text.
  change(folder / "transcripts/1_0.jsonl", "Walk to the end", "Walk to an end");
  EXPECT_FALSE(get("/run").at("list").at(0).contains("success"));
  EXPECT_FALSE(get("/run/episodes/1_0").contains("outcome"));
}

TEST_F(RunMeasuresTest, TokensAndEmptyResponsesAreCounted) {
  ask("lost", {"I do not know."});
  const fs::path empty = ask("empty", {""});
  const json lost = get("/lost/measures");
  EXPECT_EQ(lost.at("mistakes"), 18) << "three of six episodes";
  EXPECT_EQ(lost.at("unanswered"), 0);
  EXPECT_EQ(lost.at("prompt_tokens"), 1800);
  EXPECT_EQ(lost.at("answer_tokens"), 126);
  const json measures = get("/empty/measures");
  EXPECT_EQ(measures.at("unanswered"), 18);
  const json first = get("/empty").at("list").at(0);
  EXPECT_EQ(first.at("unanswered"), 3);
  EXPECT_EQ(first.at("ending"), "refused");
  EXPECT_EQ(first.at("reason"), "no-answer: empty");
  EXPECT_EQ(get("/empty/episodes/1_0").at("steps").at(0).at("flaw"), "empty");
  EXPECT_EQ(get("/empty/episodes/1_0").at("end").at("reason"), "no-answer: empty");
  write_file_atomically(empty / "usage.json", R"({"seconds": 12.5, "money": 0.25})");
  EXPECT_EQ(get("/empty/measures").at("seconds"), 12.5);
  EXPECT_EQ(get("/empty/measures").at("money"), 0.25);
  for (const char* odd : {R"({"seconds": "1", "money": -1})", "[1]", "{"}) {
    write_file_atomically(empty / "usage.json", odd);
    EXPECT_FALSE(get("/empty/measures").contains("seconds")) << odd;
    EXPECT_FALSE(get("/empty/measures").contains("money")) << odd;
  }
}

TEST_F(RunMeasuresTest, EpisodesAreSortedAndFiltered) {
  const fs::path folder = ask("run");
  ask("stay", kStay);
  for (const char* id : {"2_0", "3_1"}) {
    const std::string file = fmt::format("transcripts/{}.jsonl", id);
    write_file_atomically(folder / file, read_file(runs_.path() / "stay" / file));
  }
  // Those that end by mistakes are 2 m from the goal, which is a success.
  EXPECT_THAT(listed("/run?show=failures"), ElementsAre("2_0", "3_1"));
  EXPECT_THAT(listed("/run?show=failures&descending=1"), ElementsAre("3_1", "2_0"));
  const json failures = get("/run?show=failures&limit=1&offset=1");
  EXPECT_EQ(failures.at("episodes"), 6);
  EXPECT_EQ(failures.at("matching"), 2);
  EXPECT_THAT(listed("/run?show=failures&limit=1&offset=1"), ElementsAre("3_1"));
  EXPECT_THAT(listed("/run?show=successes"), ElementsAre("1_0", "1_1", "2_1", "3_0"));
  EXPECT_THAT(listed("/run?show=mistakes"), ElementsAre("2_1", "3_0"));
  EXPECT_THAT(listed("/run?sort=nav_error"), ElementsAre("1_0", "1_1", "2_1", "3_0", "2_0", "3_1"));
  EXPECT_THAT(listed("/run?sort=nav_error&descending=1"),
              ElementsAre("2_0", "3_1", "2_1", "3_0", "1_0", "1_1"));
  EXPECT_THAT(listed("/run?sort=steps&limit=2"), ElementsAre("2_0", "3_1"));
  EXPECT_THAT(listed("/run?sort=success&limit=3"), ElementsAre("2_0", "3_1", "1_0"));
  EXPECT_THAT(listed("/run?sort=spl&descending=1&limit=5"),
              ElementsAre("1_0", "1_1", "2_1", "3_0", "2_0"));
  EXPECT_THAT(listed("/run?sort=tokens&descending=1&limit=2"), ElementsAre("2_1", "3_0"));
  EXPECT_THAT(listed("/run?show=unstopped"), ElementsAre("2_1", "3_0"));
  fs::resize_file(folder / "transcripts/1_1.jsonl", 10);
  EXPECT_THAT(listed("/run?show=unstopped"), ElementsAre("1_1", "2_1", "3_0"));
  EXPECT_EQ(listed("/run?sort=steps").back(), "1_1") << "unknown values are last";
  EXPECT_EQ(listed("/run?sort=steps&descending=1").back(), "1_1");
  const auto [status, message] = refused("/run?sort=colour");
  EXPECT_EQ(status, 400);
  EXPECT_THAT(message, HasSubstr("sort: \"colour\"; it can be episode, success"));
  EXPECT_EQ(refused("/run?show=bad").first, 400);
}

TEST_F(RunMeasuresTest, TwoRunsAreComparedInPairs) {
  const fs::path run = ask("run"), stay = ask("stay", kStay);
  fs::remove(stay / "transcripts/3_1.jsonl");
  write_file_atomically(run / "transcripts/2_0.jsonl", read_file(stay / "transcripts/2_0.jsonl"));
  const json compared = get("/stay/compare/run");
  EXPECT_EQ(compared.at("runs").at(0).at("run"), "stay");
  EXPECT_EQ(compared.at("runs").at(1).at("run"), "run");
  EXPECT_EQ(compared.at("episodes"), 5);
  EXPECT_EQ(compared.at("only_first"), 0);
  EXPECT_EQ(compared.at("only_second"), 1);
  std::map<std::string, json> columns;
  for (const json& one : compared.at("columns")) {
    columns[one.at("short").get<std::string>()] = one;
  }
  // All of one run stay at 3 m from the goal, and one of the other. The rest end at 1 m or 2 m.
  const json& error = columns.at("NE");
  EXPECT_EQ(error.at("episodes"), 5);
  EXPECT_DOUBLE_EQ(error.at("first").get<double>(), 3);
  std::vector<double> first, second;
  const json stayed = get("/stay").at("list"), walked = get("/run?limit=5").at("list");
  for (const json& one : stayed) first.push_back(one.at("nav_error").get<double>());
  for (const json& one : walked) second.push_back(one.at("nav_error").get<double>());
  const std::vector<std::size_t> paths{0, 0, 1, 1, 2};  // instructions of a path are one group
  const auto expected = tasks::paired_bootstrap(first, second, 1, paths).front();
  EXPECT_DOUBLE_EQ(error.at("difference").at("mean").get<double>(), expected.difference.mean);
  EXPECT_DOUBLE_EQ(error.at("difference").at("low").get<double>(), expected.difference.low);
  EXPECT_DOUBLE_EQ(error.at("difference").at("high").get<double>(), expected.difference.high);
  EXPECT_DOUBLE_EQ(error.at("p").get<double>(), expected.p);
  EXPECT_LT(error["difference"]["mean"].get<double>(), 0);
  EXPECT_EQ(columns.at("Steps").at("first"), 1);
  EXPECT_EQ(columns.at("SR").at("first"), 0);
  // They differ where one succeeds.
  EXPECT_EQ(compared.at("differing"), 4);
  ASSERT_EQ(compared.at("list").size(), 4U);
  for (const json& one : compared["list"]) {
    EXPECT_EQ(one.at("first").at("success"), false);
    EXPECT_EQ(one.at("second").at("success"), true);
    EXPECT_TRUE(one.contains("instruction"));
    EXPECT_NE(one.at("episode"), "2_0");
  }
  EXPECT_EQ(get("/stay/compare/run?limit=1").at("list").size(), 1U);
  EXPECT_EQ(get("/run/compare/run").at("differing"), 0);
  EXPECT_EQ(refused("/run/compare/nobody").first, 404);
  ask("other", kStay, "test");
  const auto [status, message] = refused("/run/compare/other");
  EXPECT_EQ(status, 422);
  EXPECT_THAT(message, HasSubstr("run is a run of r2r/val_seen, and other of r2r/test"));
}

TEST_F(RunMeasuresTest, NothingIsSaidOfSuccessWhereGoalsAreHidden) {
  ask("hidden", kScript, "test");
  ask("other", kStay, "test");
  const auto silent = [this](const std::string& path) {
    const std::string body = served_.get("/api/v1/runs" + path)->body;
    for (const char* word :
         {"success", "\"spl\"", "nav_error", "oracle", "outcome\"", "v5", "\"SR\"", "\"NE\""}) {
      EXPECT_THAT(body, Not(HasSubstr(word))) << path;
    }
    return json::parse(body);
  };
  EXPECT_EQ(silent("/hidden").at("outcomes"), false);
  EXPECT_EQ(silent("").at("runs").at(0).at("outcomes"), false);
  const json measures = silent("/hidden/measures");
  EXPECT_EQ(measures.at("scored"), 0);
  EXPECT_TRUE(measures.at("scores").empty());
  EXPECT_EQ(measures.at("steps"), 16) << "what it walked is known";
  silent("/hidden/episodes/1_0");
  const json compared = silent("/hidden/compare/other");
  EXPECT_EQ(compared.at("outcomes"), false);
  EXPECT_EQ(compared.at("differing"), 6) << "they end elsewhere";
  std::vector<std::string> names;
  for (const json& one : compared.at("columns")) names.push_back(one.at("name").get<std::string>());
  EXPECT_THAT(names, ElementsAre("steps", "mistakes", "unanswered", "tokens"));
  for (const char* show : {"failures", "successes"}) {
    const auto [status, message] = refused(fmt::format("/hidden?show={}", show));
    EXPECT_EQ(status, 422);
    EXPECT_THAT(message, HasSubstr("does not have the goals of r2r/test"));
  }
  // An order by success is the order of the ids.
  const auto ids = listed("/hidden");
  EXPECT_EQ(ids.size(), 6U);
  for (const char* sort : {"success", "spl", "nav_error"}) {
    EXPECT_EQ(listed(fmt::format("/hidden?sort={}", sort)), ids);
    EXPECT_EQ(listed(fmt::format("/hidden?sort={}&descending=1", sort)), ids);
  }
  // A text that is not the site's is not shown in lists either.
  change(runs_.path() / "hidden/transcripts/1_1.jsonl", "Go past the", "GOAL Go past the");
  for (const char* path : {"/hidden", "/hidden/compare/other"}) {
    EXPECT_THAT(served_.get(std::string("/api/v1/runs") + path)->body, Not(HasSubstr("GOAL")));
  }
}

TEST_F(RunMeasuresTest, ASplitThatTheSiteLeavesOutHasNoMeasures) {
  testing::write_benchmarks(served_.root(), {});
  served_.stop();
  served_.start();
  ask("joined", kStay, "test", tasks::Task::kR4r);
  const json measures = get("/joined/measures");
  EXPECT_EQ(measures.at("outcomes"), false);
  EXPECT_EQ(measures.at("steps"), 0);
  EXPECT_TRUE(measures.at("scores").empty());
  EXPECT_EQ(refused("/joined/episodes/1_0/steps/1/pictures/0").first, 404);
}

class RunPicturesTest : public testing::AskedRuns {
 protected:
  std::string picture(const std::string& path) {
    const auto answer = served_.get("/api/v1/runs" + path);
    EXPECT_EQ(answer->status, 200) << path << answer->body;
    EXPECT_EQ(answer->get_header_value("Content-Type"), "image/jpeg");
    return "data:image/jpeg;base64," + tests::base64(answer->body);
  }
};

TEST_F(RunPicturesTest, AStripIsTheOneThatTheModelSaw) {
  Script model(kScript);
  ask_model(model, "marks", "marks");
  for (const char* id : {"1_0", "1_1"}) {
    const json steps = get(fmt::format("/marks/episodes/{}", id)).at("steps");
    ASSERT_EQ(steps.size(), kScript.size());
    for (std::size_t k = 0; k < steps.size(); ++k) {
      EXPECT_EQ(steps[k].at("pictures"), json::array({""})) << k;
      const auto& sent = model.pictures(fmt::format("r2r/val_seen/{}", id), k);
      ASSERT_EQ(sent.size(), 1U);
      EXPECT_EQ(picture(fmt::format("/marks/episodes/{}/steps/{}/pictures/0", id, k + 1)), sent[0]);
    }
  }
  const std::string path = "/api/v1/runs/marks/episodes/1_0/steps/1/pictures/0";
  const std::string tag = served_.get(path)->get_header_value("ETag");
  EXPECT_EQ(served_.get(path, {{"If-None-Match", tag}})->status, 304);
}

TEST_F(RunPicturesTest, PicturesOfPlacesComeInTheirOrder) {
  Script model({"Action: go_to B", "Action: stop"});
  ask_model(model, "maps", "mapgpt");
  const json step = get("/maps/episodes/1_0").at("steps").at(1);
  const auto& sent = model.pictures("r2r/val_seen/1_0", 1);
  const json& places = step.at("observation").at("places");
  ASSERT_EQ(sent.size(), 2U);
  ASSERT_EQ(step.at("pictures").size(), sent.size());
  for (std::size_t k = 0; k < sent.size(); ++k) {
    EXPECT_EQ(step["pictures"][k], places.at(k).at("name"));
    EXPECT_EQ(picture(fmt::format("/maps/episodes/1_0/steps/2/pictures/{}", k)), sent[k]);
  }
}

TEST_F(RunPicturesTest, APictureThatWasNotSentIsNotShown) {
  ask("text");
  Script model(kScript);
  const fs::path folder = ask_model(model, "marks", "marks");
  EXPECT_FALSE(get("/text/episodes/1_0").at("steps").at(0).contains("pictures"));
  for (const char* path :
       {"/text/episodes/1_0/steps/1/pictures/0", "/marks/episodes/1_0/steps/1/pictures/1",
        "/marks/episodes/1_0/steps/0/pictures/0", "/marks/episodes/1_0/steps/5/pictures/0",
        "/marks/episodes/1_0/steps/-1/pictures/0", "/marks/episodes/1_0/steps/x/pictures/0",
        "/marks/episodes/9_0/steps/1/pictures/0", "/nobody/episodes/1_0/steps/1/pictures/0"}) {
    EXPECT_EQ(refused(path).first, 404) << path;
  }
  // A picture of another size, or of another data set.
  change(folder / "transcripts/1_0.jsonl", R"("pictures":["strip/row)",
         R"("pictures":["strip/was)");
  EXPECT_FALSE(get("/marks/episodes/1_0").at("steps").at(0).contains("pictures"));
  EXPECT_TRUE(get("/marks/episodes/1_0").at("steps").at(1).contains("pictures"));
  EXPECT_THAT(refused("/marks/episodes/1_0/steps/1/pictures/0").second,
              HasSubstr("would draw another one"));
  change(folder / "run.json", R"("picture_size": 64)", R"("picture_size": 128)");
  EXPECT_FALSE(get("/marks/episodes/1_1").at("steps").at(0).contains("pictures"));
  for (const char* size : {"\"x\"", "1", "1e9", "-5"}) {
    change(folder / "run.json", R"("picture_size": )",
           fmt::format(R"("picture_size": {}, "was": )", size));
    EXPECT_FALSE(get("/marks/episodes/1_1").at("steps").at(0).contains("pictures")) << size;
  }
}

TEST_F(RunPicturesTest, PicturesOfAnotherTextStayHiddenWithIt) {
  const fs::path folder = ask("hidden", kScript, "test");
  change(folder / "transcripts/1_1.jsonl", "Go past the", "GOAL Go past the");
  const auto [status, message] = refused("/hidden/episodes/1_1/steps/1/pictures/0");
  EXPECT_EQ(status, 404);
  EXPECT_THAT(message, HasSubstr("whose goals are hidden"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
