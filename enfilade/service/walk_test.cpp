// People walk instructions, over real sockets.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <set>

#include "enfilade/core/errors.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"
#include "tests/support/collecting.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using testing::collection_body;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::row_steps;
using testing::Worker;

using Walk = testing::Collecting;

TEST_F(Walk, AnInstructionIsShownAndItsGoalIsNot) {
  create(collection_body("pilot", "walk"));
  Worker one = worker("one");
  std::string all = one.join().dump();
  all += one.consent().dump();
  const json leased = one.lease();
  all += leased.dump();
  const json& task = leased.at("task");
  EXPECT_EQ(task.at("instruction"), "Walk to the end of the hall, path 1.");
  EXPECT_EQ(task.at("start"), "v0");
  EXPECT_EQ(task.at("heading"), 1.5);
  all += one.task(task.at("task")).dump();
  all += one.draft(task.at("task"), {{"at", 1}}).dump();
  all += one.visit().dump();
  all += one.walk(task.at("task"), row_steps(1, 2)).dump();  // refused: a wrong start
  json jump = row_steps(0, 1);
  jump[1]["viewpoint"] = "v5";
  const std::string refused = one.walk(task.at("task"), jump).dump();
  EXPECT_THAT(refused, HasSubstr("not-adjacent"));
  all += refused;
  EXPECT_THAT(all, Not(HasSubstr("v3")));  // the goal
  EXPECT_THAT(all, Not(HasSubstr("\"path")));
  EXPECT_THAT(all, Not(HasSubstr("distance")));
}

TEST_F(Walk, StoppingNearTheGoalEarnsTheBonusAndIsToldToTheOrganiserOnly) {
  create(collection_body("pilot", "walk"));  // the goal is 3 m from the start
  Worker far = worker("far");
  const json miss = far.walk(far.begin().at("task"), row_steps(0, 0));
  EXPECT_EQ(miss.at("status"), 200);
  Worker near = worker("near");
  const json hit = near.walk(near.begin().at("task"), row_steps(0, 1));
  // The path's other instruction has the same goal: what one of them tells helps with the other.
  for (const json& told : {miss, hit}) {
    for (const char* field : {"walked", "bonus", "bonuses", "error", "distance", "practised"}) {
      EXPECT_FALSE(told.contains(field)) << field;
    }
  }
  const json visits = served_.json("/api/v1/collections/pilot/workers", organiser_).at("visits");
  EXPECT_EQ(visits.at(0).at("bonuses"), 0);  // 3 m are not less than 3
  EXPECT_EQ(visits.at(1).at("bonuses"), 1);
}

TEST_F(Walk, BonusesAreToldOnceTheyHelpWithNothing) {
  create(collection_body("pilot", "walk"));  // one path, two instructions
  Worker one = worker("one");
  EXPECT_FALSE(one.walk(one.begin().at("task"), row_steps(0, 2)).contains("bonuses"));
  const json second = one.lease().at("task");
  EXPECT_FALSE(one.visit().contains("bonuses"));  // while the second is walked, too
  EXPECT_EQ(one.walk(second.at("task"), row_steps(0, 0)).at("bonuses"), 1);
}

TEST_F(Walk, TwoInstructionsOfAPathComeOnlyWhenNoOtherPathIsFree) {
  json body = collection_body("pilot", "walk");
  body["sources"] = json::array({{{"split", "val_seen"}}});  // three paths, two instructions each
  for (int seed = 0; seed < 5; ++seed) {
    body["name"] = fmt::format("pilot-{}", seed);
    body["seed"] = seed;
    create(body);
    Worker one = worker("one", body["name"].get<std::string>());
    one.join();
    one.consent();
    std::set<std::string> starts;
    for (int k = 0; k < 6; ++k) {
      const json task = one.lease().at("task");
      const int start = task.at("start").get<std::string>().at(1) - '0';
      if (k < 3) {
        EXPECT_TRUE(starts.insert(task.at("start").get<std::string>()).second) << seed << " " << k;
      }
      one.walk(task.at("task"), row_steps(start, start + 3));
    }
    EXPECT_EQ(one.lease().at("why"), "none-left");
  }
}

// docs/service_collecting.md has the rule of the order. These are sha256("1 1 PATH NUMBER") and
// sha256("1 2 PATH NUMBER"), computed by Python's hashlib.
TEST_F(Walk, TheOrderIsAWorkersOwnAndFollowsFromTheSeed) {
  json body = collection_body("pilot", "walk");
  body["sources"] = json::array({{{"split", "val_seen"}}});
  body["seed"] = 1;
  body["per_item"] = 2;
  create(body);
  const auto order = [&](const char* name) {
    Worker one = worker(name);
    one.join();
    one.consent();
    std::vector<std::string> seen;  // "path number"
    for (int k = 0; k < 6; ++k) {
      const json task = one.lease().at("task");
      const int start = task.at("start").get<std::string>().at(1) - '0';
      const bool first = task.at("instruction").get<std::string>().starts_with("Walk");
      seen.push_back(fmt::format("{} {}", start + 1, first ? 0 : 1));
      one.walk(task.at("task"), row_steps(start, start));
    }
    return seen;
  };
  EXPECT_THAT(order("one"), ElementsAre("1 1", "3 1", "2 1", "1 0", "2 0", "3 0"));
  EXPECT_THAT(order("two"), ElementsAre("1 1", "2 1", "3 0", "2 0", "3 1", "1 0"));
}

TEST_F(Walk, OnlyMovesThatAnAgentMayMakeAreTaken) {
  create(collection_body("pilot", "walk"));
  Worker one = worker("one");
  const auto task = one.begin().at("task").get<std::int64_t>();
  const auto code_of = [&](const char* field, const json& value) {
    json steps = row_steps(0, 2);
    steps[2][field] = value;
    const json refused = one.walk(task, steps);
    EXPECT_EQ(refused.at("status"), 422) << field << value;
    return refused.at("error").at("diagnostics").at(0).at("code").get<std::string>();
  };
  EXPECT_EQ(code_of("viewpoint", "v4"), "not-adjacent");
  EXPECT_EQ(code_of("viewpoint", "v9"), "unknown-viewpoint");
  EXPECT_EQ(code_of("viewpoint", 3), "not-a-string");
  EXPECT_EQ(code_of("heading", 7), "out-of-range");
  EXPECT_EQ(code_of("elevation", -1.6), "out-of-range");
  EXPECT_EQ(code_of("seconds", 0.5), "time-runs-back");
  EXPECT_EQ(code_of("seconds", 1e9), "out-of-range");
  EXPECT_EQ(one.walk(task, json::array()).at("status"), 422);
  EXPECT_EQ(one.walk(task, 3).at("status"), 422);
  EXPECT_EQ(one.visit().at("done"), 0);
}

TEST_F(Walk, HandingInTwiceIsOnce) {
  create(collection_body("pilot", "walk"));
  Worker one = worker("one");
  const auto task = one.begin().at("task").get<std::int64_t>();
  EXPECT_EQ(one.walk(task, row_steps(0, 3)).at("done"), 1);
  EXPECT_EQ(one.walk(task, row_steps(0, 3)).at("done"), 1);
  EXPECT_EQ(one.walk(task, row_steps(0, 2)).at("error").at("code"), "already-submitted");
}

// What enfilade score does with the files.
tasks::ScoreTable score_of(const std::string& annotations, const std::string& results,
                           const std::filesystem::path& data) {
  const tasks::EpisodeSet episodes =
      tasks::make_episodes(tasks::parse_annotations(annotations, "annotations", "val_seen"),
                           graph::GraphSet::open(data / "connectivity"));
  return tasks::compute_score(tasks::parse_results(results, "results", episodes).trajectories,
                              episodes);
}

TEST_F(Walk, TheExportIsScoredLikeAnyAgents) {
  json body = collection_body("pilot", "walk");
  body["sources"] = json::array({{{"split", "val_seen"}}});  // three paths, two instructions each
  body["seed"] = 1;  // 1_1, 3_1, 2_1, 1_0, 2_0, and 3_0 is not walked
  create(body);
  Worker one = worker("one");
  one.join();
  one.consent();
  for (int k = 0; k < 5; ++k) {
    const json task = one.lease().at("task");
    const int start = task.at("start").get<std::string>().at(1) - '0';
    now_ += 100;
    one.walk(task.at("task"), row_steps(start, start + (k == 2 ? 0 : 3)));
  }
  const std::string target = "/api/v1/collections/pilot/export?split=val_seen";
  // Walks need no review: those that wait for one are in the files, unless they are not wanted.
  const auto none = served_.get(target + "&what=results&state=accepted", organiser_);
  EXPECT_EQ(none->status, 409);
  EXPECT_THAT(none->body, HasSubstr("nothing to export"));
  EXPECT_THAT(none->body, HasSubstr("5 not reviewed yet"));
  const auto file = served_.get(target + "&what=results", organiser_);
  EXPECT_THAT(file->get_header_value("Content-Disposition"),
              HasSubstr("human_results_val_seen.json"));
  // The third path has one walk of its two: it is left out of both, and the server says so.
  EXPECT_EQ(file->get_header_value("X-Enfilade-Export"),
            "4 of 6 instructions have a walk; 1 walk is left out: 1 of paths with an instruction "
            "that no worker has walked");
  const json report = served_.json(target + "&what=report", organiser_);
  EXPECT_EQ(report.at("items"), 6);
  EXPECT_EQ(report.at("exported"), json({{"items", 4}, {"paths", 2}, {"tasks", 4}}));
  EXPECT_EQ(report.at("left_out"),
            json({{"waiting", 0}, {"rejected", 0}, {"repeated", 0}, {"incomplete", 1}}));
  const std::string annotations = served_.get(target + "&state=all", organiser_)->body;
  const tasks::ScoreTable score = score_of(annotations, file->body, served_.root() / "data");
  EXPECT_EQ(json::parse(annotations).size(), 2U);
  EXPECT_THAT(tasks::to_json(score), HasSubstr("success"));
  const json means = json::parse(tasks::to_json(score)).at("means");
  EXPECT_DOUBLE_EQ(means.at("success").at("mean").get<double>(), 0.75);
  EXPECT_DOUBLE_EQ(means.at("nav_error").at("mean").get<double>(), 0.75);  // one of 3 m
  const json walks = json::parse(served_.get(target + "&what=walks&state=all", organiser_)->body);
  ASSERT_EQ(walks.size(), 4U);
  EXPECT_EQ(walks[0].at("instr_id"), "1_0");
  EXPECT_EQ(walks[0].at("steps"), row_steps(0, 3));
  EXPECT_EQ(walks[0].at("camera").at("width"), 640);
  EXPECT_EQ(walks[0].at("seconds"), 100);  // the server's
  EXPECT_EQ(walks[0].at("page_seconds"), 3.0);
  EXPECT_EQ(walks[0].at("leased"), "1970-01-12T13:51:40Z");  // the fourth: 1,000,300 s
  EXPECT_EQ(served_.get(target + "&what=else", organiser_)->status, 400);
}

TEST_F(Walk, GoalsOfASecretPhaseAreSecretHereToo) {
  json body = collection_body("pilot", "walk");
  body["sources"] = json::array({{{"split", "test"}, {"most", 1}}});
  const json made = create(body);
  EXPECT_EQ(made.at("splits")[0].at("goals_hidden"), true);
  std::string all = made.dump();
  for (const char* name : {"one", "two"}) {  // of the path's two instructions
    Worker one = worker(name);
    const json task = one.begin();
    all += task.dump();
    const json done = one.walk(task.at("task"), row_steps(0, 1));
    EXPECT_FALSE(done.contains("bonuses"));  // not even whether it was near
    all += done.dump();
  }
  const std::string work = "/api/v1/collections/pilot/work";
  const std::string seen = served_.get(work, reviewer_)->body;
  EXPECT_THAT(seen, Not(HasSubstr("bonus")));
  EXPECT_THAT(served_.get(work, organiser_)->body, HasSubstr("\"bonus\":true"));
  const std::string target = "/api/v1/collections/pilot/export?split=test&state=all";
  EXPECT_EQ(served_.get(target, organiser_)->status, 403);
  all += seen + served_.get(work, organiser_)->body + served_.get(target, organiser_)->body +
         served_.get(target + "&what=results", organiser_)->body +
         served_.get(target + "&what=walks", organiser_)->body +
         served_.get("/api/v1/tasks/1", organiser_)->body;
  EXPECT_THAT(all, HasSubstr("v1"));
  EXPECT_THAT(all, Not(HasSubstr("v3")));  // the goal
  EXPECT_THAT(all, Not(HasSubstr("error_m")));
}

// Whoever brings the paths, under whatever name.
TEST_F(Walk, HowNearAWorkerComesToASecretGoalIsNotTold) {
  json paths = json::parse(to_json(testing::row_annotations("test", true)));
  json body = collection_body("pilot", "walk");
  body["sources"] = json::array({{{"split", "mine"}, {"paths", json::array({paths[0]})}}});
  EXPECT_EQ(create(body).at("splits")[0].at("goals_hidden"), true);
  paths[0]["path"].erase(3);  // another goal
  body["name"] = "other";
  body["sources"][0]["paths"][0] = paths[0];
  EXPECT_EQ(create(body).at("splits")[0].at("goals_hidden"), false);
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
