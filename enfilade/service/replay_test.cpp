// Runs of the arena, looked at over real sockets.
#include <gmock/gmock.h>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/arena/play.h"
#include "enfilade/service/sessions/painters.h"
#include "enfilade/service/sessions/replays.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "tests/support/asked_runs.h"
#include "tests/support/refusal.h"
#include "tests/support/served_benchmarks.h"
#include "tests/support/served_data.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

using ReplayTest = testing::AskedRuns;
using testing::kScript;

TEST_F(ReplayTest, ARunIsShownStepByStep) {
  ask("a run");
  const json runs = get("").at("runs");
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_EQ(runs[0], json::parse(R"({"run": "a run", "task": "r2r", "split": "val_seen",
                                     "model": "scripted", "prompt": "text", "outcomes": true,
                                     "episodes": 6})"));
  const json run = get("/a%20run");
  ASSERT_EQ(run.at("list").size(), 6U);
  EXPECT_EQ(run.at("matching"), 6);
  EXPECT_EQ(run["list"][1],
            json::parse(R"({"episode": "1_1", "instruction": "Go past the <b>table</b>.",
                            "ending": "stopped", "steps": 4, "mistakes": 0, "unanswered": 0,
                            "prompt_tokens": 400, "answer_tokens": 28, "success": true,
                            "spl": 1.0, "nav_error": 1.0})"));
  EXPECT_EQ(get("/a%20run?offset=5").at("list").size(), 1U);
  EXPECT_EQ(get("/a%20run?limit=2").at("list").size(), 2U);

  const json episode = get("/a%20run/episodes/1_1");
  EXPECT_EQ(episode.at("instruction"), "Go past the <b>table</b>.");
  EXPECT_EQ(episode.at("scan"), "row");
  EXPECT_FALSE(episode.contains("place_problem"));
  const json& steps = episode.at("steps");
  ASSERT_EQ(steps.size(), 4U);
  const std::vector<std::string> stood{"v0", "v0", "v1", "v2"};
  for (std::size_t k = 0; k < stood.size(); ++k) {
    EXPECT_EQ(steps[k].at("at").at("viewpoint"), stood[k]) << k;
    const json& seen = steps[k].at("observation");
    EXPECT_NEAR(steps[k]["at"].at("heading").get<double>(), seen.at("heading").get<double>(), 0.01);
    EXPECT_EQ(steps[k]["at"].at("places").size(), seen.at("places").size());
    EXPECT_EQ(steps[k].at("prompt_tokens"), 100);
    EXPECT_EQ(steps[k].at("answer_tokens"), 7);
  }
  EXPECT_EQ(steps[0].at("text"), kScript[0]) << "text stays text";
  EXPECT_EQ(steps[0].at("call"), (json{{"tool", "look"}, {"argument", "left"}}));
  EXPECT_EQ(steps[0].at("told"), "You look left.");
  EXPECT_EQ(steps[0].at("at").at("path"), json::array({"v0"}));
  EXPECT_EQ(steps[1].at("at").at("path"), json::array()) << "a look walks nowhere";
  EXPECT_EQ(steps[2].at("at").at("path"), json::array({"v1"}));
  EXPECT_EQ(steps[2].at("at").at("places"), (json{{"A", "v0"}, {"C", "v2"}}));
  EXPECT_EQ(episode.at("end").at("ending"), "stopped");
  EXPECT_EQ(episode.at("end").at("at").at("viewpoint"), "v2");
}

TEST_F(ReplayTest, WhatCouldNotBeReadIsAStepToo) {
  ask("lost", {"I do not know."});
  const json episode = get("/lost/episodes/2_0");
  ASSERT_EQ(episode.at("steps").size(), 3U);
  EXPECT_TRUE(episode["steps"][1].at("call").is_null());
  EXPECT_EQ(episode["steps"][1].at("text"), "I do not know.");
  EXPECT_THAT(episode["steps"][1].at("told").get<std::string>(), HasSubstr("Nothing was done"));
  EXPECT_EQ(episode["steps"][2].at("at").at("viewpoint"), "v1");
  EXPECT_EQ(episode.at("end").at("ending"), "mistakes");
  EXPECT_FALSE(episode.contains("place_problem"));
}

TEST_F(ReplayTest, AWayBackHasAllItsViewpoints) {
  ask("back", {"Action: go_to B", "Action: go_to C", "Action: back_to A", "Action: stop"});
  const json steps = get("/back/episodes/1_0").at("steps");
  EXPECT_EQ(steps.at(3).at("at").at("path"), (json{"v1", "v0"}));
  EXPECT_EQ(steps.at(3).at("at").at("viewpoint"), "v0");
}

TEST_F(ReplayTest, OtherBenchmarksAreWalkedAgainToo) {
  testing::write_benchmarks(served_.root(), {});
  served_.restart_with(R"({"name": "open", "split": "val_seen"})");  // else R4R's would be left out
  for (const tasks::Task task : testing::kOtherTasks) {
    if (task == tasks::Task::kR2rBack || task == tasks::Task::kSoon) continue;  // not walked by ask
    const std::string name(tasks::benchmark(task).name);
    const bool named = task == tasks::Task::kReverie;
    ask(name, {"Action: go_to B", named ? "Action: answer 1" : "Action: stop"}, "test", task);
    const json run = get("/" + name);
    EXPECT_EQ(run.at("task"), name);
    const auto id = run.at("list").at(0).at("episode").get<std::string>();
    const json episode = get("/" + name + "/episodes/" + id);
    EXPECT_FALSE(episode.contains("place_problem")) << name << episode.value("place_problem", "");
    EXPECT_EQ(episode.at("end").at("ending"), "stopped") << name;
    EXPECT_EQ(episode["end"].at("at").at("viewpoint"), "v1") << name;
    EXPECT_EQ(episode.at("steps").at(1).at("observation").contains("things"), named) << name;
  }
}

// Assistants and Python write no run.json.
TEST_F(ReplayTest, TheSplitOfARunWithoutDescriptionIsFound) {
  arena::Play play(std::make_unique<arena::GraphWorld>(episodes("val_seen")), {},
                   arena::Prompt::named("text"),
                   {.episodes = {2}, .folder = runs_.path() / "played"});
  play.begin();
  play.call(arena::read_call("go_to", R"({"place": "B"})"));
  play.call(arena::read_call("stop", {}));
  const json run = get("").at("runs").at(0);
  EXPECT_EQ(run.at("task"), "r2r");
  EXPECT_EQ(run.at("split"), "val_seen");
  EXPECT_TRUE(run.at("model").is_null());
  const json episode = get("/played/episodes/2_0");
  EXPECT_FALSE(episode.at("steps").at(0).contains("text"));
  EXPECT_EQ(episode.at("end").at("at").at("viewpoint"),
            episode["steps"][0].at("at").at("places").at("B"));
}

TEST_F(ReplayTest, RunsThatHaveAnEpisodeAreFound) {
  ask("one");
  ask("two");
  fs::remove(runs_.path() / "two/transcripts/3_1.jsonl");
  EXPECT_EQ(get("?episode=3_0").at("runs").size(), 2U);
  ASSERT_EQ(get("?episode=3_1").at("runs").size(), 1U);
  EXPECT_EQ(get("?episode=3_1").at("runs")[0].at("run"), "one");
  EXPECT_TRUE(get("?episode=nobody").at("runs").empty());
}

TEST_F(ReplayTest, BrokenTranscriptsAreNamedWithTheirLine) {
  const fs::path transcripts = ask("run") / "transcripts";
  const std::string whole = read_file(transcripts / "1_0.jsonl");
  write_file_atomically(transcripts / "1_0.jsonl", whole.substr(0, whole.rfind("{\"ending")));
  change(transcripts / "1_1.jsonl", "{\"observation\"", "{observation");
  change(transcripts / "2_0.jsonl", "\"told\":\"You", "\"tell\":\"You");
  write_file_atomically(transcripts / "2_1.jsonl", "");
  change(transcripts / "3_0.jsonl", "\"heading\":", "\"heading\":\"<b>\",\"was\":");
  fs::resize_file(transcripts / "3_1.jsonl", sessions::kMostTranscriptBytes + 1);
  const json list = get("/run").at("list");
  ASSERT_EQ(list.size(), 6U);
  EXPECT_EQ(list[0].at("problem"), "the last line is no end of an episode");
  EXPECT_EQ(list[1].at("ending"), "stopped") << "only the end is read for the list";
  EXPECT_TRUE(list[3].contains("problem"));
  const std::vector<std::pair<std::string, std::string>> faults{
      {"1_0", "transcripts/1_0.jsonl, line 6: the end is missing"},
      {"1_1", "transcripts/1_1.jsonl, line 2: no JSON object of at most 16 levels"},
      {"2_0", "transcripts/2_0.jsonl, line 2: told: not a text"},
      {"2_1", "transcripts/2_1.jsonl, line 1: no JSON object of at most 16 levels"},
      {"3_0", "transcripts/3_0.jsonl, line 2: observation.heading: not a number"},
      {"3_1", "transcripts/3_1.jsonl: 16777217 bytes, 16777216 at most"}};
  for (const auto& [id, says] : faults) {
    const auto [status, message] = refused("/run/episodes/" + id);
    EXPECT_EQ(status, 422) << id;
    EXPECT_THAT(message, HasSubstr(says));
    EXPECT_THAT(message, Not(HasSubstr(runs_.path().string())));
  }
  write_file_atomically(runs_.path() / "run/run.json", "[1");
  EXPECT_EQ(get("").at("runs")[0].at("problem"), "run.json: no JSON object");
}

TEST_F(ReplayTest, WhatIsDeepOrLongDoesNotEndTheServer) {
  const fs::path folder = ask("run");
  const std::string deep(200'000, '[');
  const auto nest = [&](const std::string& id) {
    const fs::path file = folder / "transcripts" / (id + ".jsonl");
    std::string text = read_file(file);
    text.insert(text.find("\"map\":") + 6, deep + std::string(deep.size(), ']') + ",\"was\":");
    write_file_atomically(file, text);
  };
  nest("1_0");
  write_file_atomically(folder / "transcripts/1_1.jsonl", deep);
  std::string many = "[";
  for (int k = 0; k < 1'000'000; ++k) many += "1,";
  write_file_atomically(folder / "transcripts/2_0.jsonl", many);
  EXPECT_THAT(refused("/run/episodes/1_0").second, HasSubstr("line 2: no JSON object of at most"));
  EXPECT_THAT(refused("/run/episodes/1_1").second, HasSubstr("line 1: no JSON object of at most"));
  EXPECT_THAT(refused("/run/episodes/2_0").second, HasSubstr("more than 1000000 values"));
  write_file_atomically(folder / "run.json", deep);
  EXPECT_EQ(get("").at("runs")[0].at("problem"), "run.json: no JSON object");
  EXPECT_EQ(get("/run").at("list")[1].at("problem"), "the last line is no end of an episode");
  EXPECT_TRUE(get("/run/episodes/3_0").contains("end"));
}

TEST_F(ReplayTest, NoNameLeadsOutOfTheRuns) {
  const fs::path folder = ask("run");
  write_file_atomically(served_.root() / "secret.jsonl",
                        read_file(folder / "transcripts/1_0.jsonl"));
  fs::create_symlink(served_.root() / "secret.jsonl", folder / "transcripts/9_0.jsonl");
  make_folder(runs_.path() / "linked");
  fs::create_directory_symlink(folder / "transcripts", runs_.path() / "linked/transcripts");
  make_folder(runs_.path() / "empty");
  EXPECT_EQ(get("").at("runs").size(), 1U) << "neither links nor folders without transcripts";
  EXPECT_EQ(get("/run").at("episodes"), 6);
  for (const char* path :
       {"/..", "/.", "/%2e%2e", "/%2e%2e%2frun", "/run%2f..", "/linked", "/empty", "/Run",
        "/run%00", "/run/episodes/9_0", "/run/episodes/..%2f..%2frun", "/run/episodes/%2e%2e",
        "/run/episodes/1_0.jsonl", "/run/episodes/1_0%00", "/run/episodes/%252e%252e"}) {
    const auto answer = served_.get(std::string("/api/v1/runs") + path);
    ASSERT_TRUE(answer) << path;
    EXPECT_TRUE(answer->status == 404 || answer->status == 400) << path << " " << answer->status;
  }
}

TEST_F(ReplayTest, OddIdsAreFoundByWhatTheyMean) {
  const fs::path transcripts = ask("run") / "transcripts";
  fs::rename(transcripts / "1_0.jsonl", transcripts / "a%3ab%2f.jsonl");
  EXPECT_EQ(get("/run").at("list")[5].at("episode"), "a:b/");
  EXPECT_EQ(refused("/run/episodes/1_0").first, 404);
  fs::rename(transcripts / "1_1.jsonl", transcripts / "a%3ab.jsonl");
  const json episode = get("/run/episodes/a%3Ab");
  EXPECT_EQ(episode.at("episode"), "a:b");
  EXPECT_THAT(episode.at("place_problem").get<std::string>(), HasSubstr("no such episode"));
}

TEST_F(ReplayTest, NothingOfAGoalIsTold) {
  const fs::path file = ask("hidden", kScript, "test") / "transcripts/1_0.jsonl";
  change(file, "{\"observation\":{", "{\"goal\":\"GOAL\",\"observation\":{\"goal\":\"GOAL\",");
  change(file, "\"result\":{", "\"goal\":\"GOAL\",\"result\":{\"predObjId\":\"GOAL\",");
  const std::string text = served_.get("/api/v1/runs/hidden/episodes/1_0")->body;
  const json episode = json::parse(text);
  EXPECT_EQ(episode.at("end").at("at").at("viewpoint"), "v2");
  EXPECT_FALSE(episode.contains("place_problem"));
  EXPECT_THAT(text, Not(HasSubstr("GOAL")));
  EXPECT_THAT(text, Not(HasSubstr("trajectory")));
  EXPECT_THAT(text, Not(HasSubstr("v5")));
  EXPECT_THAT(served_.get("/api/v1/runs/hidden")->body, Not(HasSubstr("GOAL")));
}

// Of REVERIE ids may name the object: those of a file with goals are others than the site's.
TEST_F(ReplayTest, IdsAndTextsThatTellGoalsStayHidden) {
  const fs::path folder = ask("hidden", kScript, "test");
  fs::rename(folder / "transcripts/1_0.jsonl", folder / "transcripts/1_777_0.jsonl");
  change(folder / "transcripts/1_1.jsonl", "Go past the", "GOAL Go past the");
  const std::string list = served_.get("/api/v1/runs/hidden")->body;
  EXPECT_THAT(list, Not(HasSubstr("777")));
  EXPECT_EQ(json::parse(list).at("episodes"), 5);
  EXPECT_EQ(refused("/hidden/episodes/1_777_0").first, 404);
  EXPECT_TRUE(get("?episode=1_777_0").at("runs").empty());
  const auto [status, message] = refused("/hidden/episodes/1_1");
  EXPECT_EQ(status, 404);
  EXPECT_THAT(message, Not(HasSubstr("GOAL")));
  EXPECT_EQ(get("/hidden/episodes/2_0").at("scan"), "wing");
}

// The texts of R4R tell where paths of R2R end, so a site with secret goals leaves its split out.
TEST_F(ReplayTest, RunsOfASplitThatTheSiteLeavesOutAreNotShown) {
  testing::write_benchmarks(served_.root(), {});
  served_.stop();
  served_.start();
  ask("joined", {"Action: stop"}, "test", tasks::Task::kR4r);
  const json run = get("/joined");
  EXPECT_EQ(run.at("episodes"), 0);
  EXPECT_TRUE(run.at("list").empty());
  EXPECT_THAT(run.at("problem").get<std::string>(), HasSubstr("secret goals"));
  EXPECT_EQ(refused("/joined/episodes/1_0").first, 404);
}

TEST_F(ReplayTest, AWalkThatComesOutDifferentlyIsNotShownInAWrongPlace) {
  const fs::path file = ask("run") / "transcripts/1_0.jsonl";
  const std::string text = read_file(file);
  const std::size_t third = text.find("{\"observation\"", text.find("\"told\":\"You went to B"));
  const std::size_t at = text.find("\"distance\":", third);
  write_file_atomically(file, std::string(text).insert(at + 11, "9"));
  const json episode = get("/run/episodes/1_0");
  EXPECT_THAT(episode.at("place_problem").get<std::string>(), HasSubstr("step 3 comes out"));
  EXPECT_TRUE(episode["steps"][1].contains("at"));
  EXPECT_FALSE(episode["steps"][2].contains("at"));
  EXPECT_FALSE(episode["end"].contains("at"));
}

TEST_F(ReplayTest, WalksInContinuousSpaceAreShownInWords) {
  make_folder(runs_.path() / "free/transcripts");
  write_file_atomically(runs_.path() / "free/run.json",
                        R"({"task": "r2r-ce", "split": "val_seen"})");
  const json seen{{"instruction", "Go."}, {"step", 0},  {"heading", 1.5},
                  {"elevation", 0},       {"told", ""}, {"tools", json::array()}};
  const json step{{"observation", seen},
                  {"call", {{"tool", "move"}, {"argument", "forward,left"}}},
                  {"told", "You did 2 of 2."}};
  write_file_atomically(runs_.path() / "free/transcripts/12.jsonl",
                        json{{"episode", "12"}, {"instruction", "Go."}}.dump() + "\n" +
                            step.dump() + "\n" +
                            R"({"ending": "stopped", "steps": 1, "mistakes": 0, "result": {}})");
  const json episode = get("/free/episodes/12");
  EXPECT_EQ(episode.at("steps").at(0).at("call").at("argument"), "forward,left");
  EXPECT_FALSE(episode["steps"][0].contains("at"));
  EXPECT_THAT(episode.at("place_problem").get<std::string>(), HasSubstr("continuous"));
}

TEST_F(ReplayTest, AFolderMayBeARunItself) {
  const fs::path folder = ask("run");
  const auto site = Site::open(served_.root() / "data");
  const auto painters = std::make_shared<sessions::Painters>(site);
  sessions::Replays one(site, folder, painters);
  EXPECT_EQ(one.runs("").at("runs").at(0).at("run"), "run");
  EXPECT_EQ(one.episode("run", "1_0").at("steps").size(), 4U);
  sessions::Replays none(site, {}, painters);
  EXPECT_TRUE(none.runs("").at("runs").empty());
  EXPECT_THAT(
      tests::refusal<FileError>([&] { sessions::Replays(nullptr, folder / "run.json", nullptr); }),
      HasSubstr("run.json: not a folder"));
}

TEST_F(ReplayTest, PagesAreToldWhetherThereAreRuns) {
  EXPECT_EQ(served_.json("/api/v1/scans").at("runs"), true);
  EXPECT_EQ(served_.json("/api/v1/scans/row").at("runs"), true);
  testing::Served other;
  EXPECT_EQ(other.json("/api/v1/scans").at("runs"), false);
  EXPECT_EQ(other.json("/api/v1/scans/row").at("runs"), false);
  EXPECT_TRUE(other.json("/api/v1/runs").at("runs").empty());
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
