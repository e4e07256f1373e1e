// What makes a collection honest and its workers informed, over real sockets: practice, screening,
// attention checks, conditions, times, changes.
#include <gmock/gmock.h>
#include <map>
#include <set>

#include "tests/support/collecting.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using testing::collection_body;
using ::testing::HasSubstr;
using ::testing::Not;
using testing::read_answer;
using testing::row_steps;
using testing::Worker;

constexpr const char* kText = "Walk past the table and stop at the door.";

class Conditions : public testing::Collecting {
 protected:
  static json all_paths(const std::string& kind) {
    json body = collection_body("pilot", kind);
    body["sources"] = json::array({{{"split", "val_seen"}}});
    return body;
  }
  static json question(const char* text) {
    return {{"question", text}, {"choices", {"Yes", "No", "Maybe"}}, {"accept", {"Yes", "Maybe"}}};
  }
  json change(const json& fields, const std::string& name = "pilot") {
    return read_answer(served_.client().Patch("/api/v1/collections/" + name, organiser_,
                                              fields.dump(), "application/json"));
  }
  json copy(const json& body, const std::string& name = "pilot") {
    return read_answer(served_.client().Post("/api/v1/collections/" + name + "/copy", organiser_,
                                             body.dump(), "application/json"));
  }
  std::vector<std::string> listed(const std::string& query) {
    std::vector<std::string> names;
    const json answer = served_.json("/api/v1/collections" + query, organiser_);
    for (const json& one : answer.at("collections"))
      names.push_back(one.at("collection").get<std::string>());
    return names;
  }
  static json answer(Worker& one, const json& question, const char* choice) {
    return one.put(
        "/api/v1/visit/answers",
        {{"answers", json::array({{{"question", question.at("question")}, {"choice", choice}}})}});
  }
};

TEST_F(Conditions, PracticeComesFirstWithFeedbackAndIsNeverCounted) {
  json body = all_paths("walk");
  body["sources"].push_back({{"split", "val_seen"}, {"most", 1}, {"practice", true}});
  body["tasks_per_visit"] = 3;
  const json made = create(body);
  // The first path is practice: its two instructions are no work.
  EXPECT_EQ(made.at("splits")[0].at("items"), 4);
  for (const char* name : {"one", "two"}) {  // everybody does it
    Worker one = worker(name);
    EXPECT_EQ(one.join().at("visit").at("practice"), 1);
    one.consent();
    const json task = one.lease().at("task");
    EXPECT_EQ(task.at("practice"), true);
    EXPECT_EQ(task.at("start"), "v0");
    const json done = one.walk(task.at("task"), row_steps(0, 1));
    EXPECT_EQ(done.at("practised").at("reached"), true);
    EXPECT_EQ(done.at("practised").at("distance"), 2.0);
    EXPECT_EQ(done.at("done"), 0);
    EXPECT_EQ(done.at("finished"), false);
    EXPECT_FALSE(done.contains("practice"));
    EXPECT_FALSE(one.lease().at("task").contains("practice"));
  }
  EXPECT_EQ(progress().at("items"), 4);
  EXPECT_EQ(progress().at("submitted"), 0);
  EXPECT_EQ(served_.json("/api/v1/collections/pilot/work?state=all", organiser_).at("matching"), 0);
  const std::string target = "/api/v1/collections/pilot/export?split=val_seen";
  EXPECT_EQ(served_.get(target + "&what=results", organiser_)->status, 409);
  const json tasks = served_.json(target + "&what=tasks", organiser_);
  ASSERT_EQ(tasks.size(), 2U);  // the full record has them, and says so
  EXPECT_EQ(tasks[0].at("practice"), true);
}

TEST_F(Conditions, WhoPractisesWritingSeesAnExampleAfterwards) {
  json body = all_paths("write");
  body["sources"].push_back({{"split", "val_seen"}, {"most", 1}, {"practice", true}});
  create(body);
  Worker one = worker("one");
  const json task = one.begin();
  EXPECT_THAT(task.dump(), Not(HasSubstr("Walk to the end")));  // not before
  const json done = one.write(task.at("task"), kText);
  EXPECT_EQ(done.at("practised").at("example"), "Walk to the end of the hall, path 1.");
  EXPECT_EQ(done.at("done"), 0);
}

TEST_F(Conditions, AWrongAnswerToTheScreeningEndsTheVisit) {
  json body = all_paths("write");
  body["platform"] = {
      {"kind", "prolific"}, {"completion_code", "C0DE"}, {"screen_out_code", "0UT"}};
  body["screening"] = {question("Are you at least 18 years old?"), question("Can you see well?")};
  const json made = create(body);
  EXPECT_EQ(made.at("screening")[0].at("accept"), json({"Yes", "Maybe"}));
  const auto visitor = [&](const char* id) {
    return come({{"PROLIFIC_PID", id}, {"STUDY_ID", "s"}, {"SESSION_ID", id}});
  };
  Worker one = visitor("p1");
  EXPECT_FALSE(one.join().at("visit").contains("questions"));  // consent comes first
  const json asked = one.consent().at("questions");
  ASSERT_EQ(asked.size(), 2U);
  EXPECT_FALSE(asked[0].contains("accept"));
  EXPECT_EQ(one.lease().at("why"), "questions");
  EXPECT_EQ(answer(one, asked[0], "Perhaps").at("status"), 422);
  EXPECT_EQ(answer(one, {{"question", 999}}, "Yes").at("status"), 404);
  EXPECT_EQ(answer(one, asked[0], "Maybe").at("questions").size(), 1U);
  const json out = answer(one, asked[1], "No");
  EXPECT_EQ(out.at("screened_out"), true);
  EXPECT_EQ(out.at("completion").at("code"), "0UT");
  answer(one, asked[1], "Yes");  // too late
  EXPECT_EQ(one.lease().at("why"), "screened-out");
  EXPECT_EQ(visitor("p1").join().at("visit").at("screened_out"), true);

  Worker two = visitor("p2");
  two.join();
  two.consent();
  for (const json& each : asked) answer(two, each, "Yes");
  EXPECT_TRUE(two.lease().at("task").is_object());
  const json visits = served_.json("/api/v1/collections/pilot/workers", organiser_).at("visits");
  EXPECT_EQ(visits[0].at("screened_out"), true);
  EXPECT_EQ(visits[1].at("screened_out"), false);
}

TEST_F(Conditions, AttentionChecksComeBetweenTasksAndAreCounted) {
  json body = all_paths("write");
  body["checks"] = {question("Choose Yes."), question("Choose Yes once more.")};
  body["check_every"] = 2;
  create(body);
  Worker one = worker("one");
  const auto first = one.begin().at("task").get<std::int64_t>();
  EXPECT_FALSE(one.visit().contains("questions"));  // the first task comes without
  const json check = one.write(first, kText).at("questions");
  ASSERT_EQ(check.size(), 1U);
  EXPECT_EQ(check[0].at("text"), "Choose Yes.");
  EXPECT_EQ(one.lease().at("why"), "questions");
  const json after = answer(one, check[0], "No");
  for (const char* told : {"accepted", "screened_out", "questions"}) {
    EXPECT_FALSE(after.contains(told));
  }
  for (int k = 0; k < 2; ++k) one.write(one.lease().at("task").at("task"), kText);
  EXPECT_EQ(one.lease().at("why"), "none-left");  // no more tasks: no more checks
  const json visit = served_.json("/api/v1/collections/pilot/workers", organiser_).at("visits")[0];
  EXPECT_EQ(visit.at("checks"), 1);
  EXPECT_EQ(visit.at("checks_failed"), 1);
  const std::string by_worker = "/api/v1/collections/pilot/work/workers";
  EXPECT_EQ(served_.json(by_worker, reviewer_).at("workers")[0].at("checks_failed"), 1);
}

TEST_F(Conditions, FaultsOfQuestionsAreShown) {
  json body = all_paths("write");
  body["screening"] = {
      {{"question", "?"}, {"choices", json::array({"Yes"})}, {"accept", json::array({"Yes"})}},
      {{"question", "?"}, {"choices", {"Yes", "No"}}, {"accept", json::array({"Perhaps"})}},
      {{"question", "?"}, {"choices", {"Yes", "No"}}, {"accept", json::array()}}};
  body["checks"] = 3;
  body["pay"] = "two\nlines";
  body["minutes"] = -1;
  body["check_every"] = 0;
  body["seed"] = -1;
  const json refused = create(body);
  EXPECT_EQ(refused.at("status"), 422);
  for (const char* where :
       {"$.screening[0].choices", "$.screening[1].accept", "$.screening[2].accept", "$.checks",
        "$.pay", "$.minutes", "$.check_every", "$.seed"}) {
    EXPECT_THAT(refused.dump(), HasSubstr(where));
  }
}

TEST_F(Conditions, AWorkerKnowsHowMuchThereIsToDo) {
  json body = all_paths("write");
  body["pay"] = "$1.20 a path";
  body["minutes"] = 4;
  create(body);
  const json joined = worker("one").join();
  EXPECT_EQ(joined.at("collection").at("pay"), "$1.20 a path");
  EXPECT_EQ(joined.at("collection").at("minutes"), 4.0);
  EXPECT_EQ(joined.at("visit").at("of"), 3);
  Worker one = worker("one");
  const auto task = one.begin().at("task").get<std::int64_t>();
  EXPECT_EQ(one.visit().at("of"), 3);  // the one that is held among them
  EXPECT_EQ(one.write(task, kText).at("of"), 3);
  one.give_back(one.lease().at("task").at("task"));
  EXPECT_EQ(one.visit().at("of"), 2);  // what was skipped is not offered again
  change({{"tasks_per_visit", 1}});
  EXPECT_EQ(one.visit().at("of"), 1);
}

TEST_F(Conditions, WorkersGetOrdersOfTheirOwn) {
  json body = all_paths("write");
  body["per_item"] = 12;
  body["seed"] = 1;
  create(body);
  std::map<std::string, int> first;
  for (int k = 0; k < 12; ++k) {
    ++first[worker(std::to_string(k)).begin().at("path").at(0).get<std::string>()];
  }
  EXPECT_EQ(first.size(), 3U);  // each of the three paths is somebody's first
}

TEST_F(Conditions, TimesAreTheServers) {
  create(all_paths("write"));
  Worker one = worker("one");
  const json task = one.begin();
  now_ += 20;  // and the page says 42.5 s
  one.write(task.at("task"), kText);
  const json work = served_.json("/api/v1/collections/pilot/work", organiser_).at("work")[0];
  EXPECT_EQ(work.at("seconds"), 20);
  EXPECT_EQ(work.at("page_seconds"), 42.5);
  EXPECT_EQ(work.at("leased"), "1970-01-12T13:46:40Z");
  EXPECT_EQ(work.at("submitted"), "1970-01-12T13:47:00Z");
  EXPECT_EQ(work.at("flags"), json::array({"time-mismatch"}));
  const json second = one.lease().at("task");
  now_ += 60;
  one.write(second.at("task"), kText);
  const json rest = served_.json("/api/v1/collections/pilot/work", organiser_).at("work")[1];
  EXPECT_FALSE(rest.contains("flags"));
  now_ -= 3600;  // a clock that is set back
  const json third = one.lease().at("task");
  now_ -= 60;
  EXPECT_EQ(one.write(third.at("task"), kText).at("status"), 200);
  const json last = served_.json("/api/v1/collections/pilot/work", organiser_).at("work")[2];
  EXPECT_FALSE(last.contains("seconds"));
  EXPECT_EQ(
      served_.json("/api/v1/collections/pilot/workers", organiser_).at("visits")[0].at("seconds"),
      80);
}

TEST_F(Conditions, ACollectionIsChanged) {
  create(all_paths("write"));
  Worker one = worker("one");
  one.write(one.begin().at("task"), kText);
  const json changed = change({{"title", "Another title"},
                               {"instructions", "Write better."},
                               {"pay", "$2"},
                               {"per_item", 1},
                               {"lease_minutes", 5}});
  EXPECT_EQ(changed.at("title"), "Another title");
  EXPECT_EQ(changed.at("pay"), "$2");
  EXPECT_EQ(changed.at("lease_minutes"), 5);
  EXPECT_EQ(changed.at("consent"), "# Consent\n\nYou *may* stop at any time.");
  EXPECT_EQ(progress().at("complete"), 1);  // one is enough now
  EXPECT_EQ(change({{"per_item", 2}}).at("progress").at("complete"), 0);
  EXPECT_EQ(change({{"title", ""}}).at("status"), 422);
  EXPECT_EQ(change({{"state", "gone"}}).at("status"), 422);
  EXPECT_EQ(one.visit().at("consented"), true);
}

TEST_F(Conditions, AnotherConsentTextHasToBeAgreedToAnew) {
  create(all_paths("write"));
  Worker one = worker("one");
  one.begin();
  now_ += 10;
  change({{"title", "The same consent"}});
  EXPECT_EQ(one.visit().at("consented"), true);
  change({{"consent", "We record your screen."}});
  EXPECT_EQ(one.visit().at("consented"), false);
  EXPECT_EQ(one.lease().at("error").at("code"), "consent-required");
  now_ += 10;
  EXPECT_EQ(one.consent().at("consented"), true);
  EXPECT_TRUE(one.lease().at("task").is_object());
}

TEST_F(Conditions, ACopyHasAllButTheWork) {
  json body = all_paths("walk");
  body["sources"].push_back({{"split", "val_seen"}, {"most", 1}, {"practice", true}});
  body["checks"] = json::array({question("Choose Yes.")});
  body["pay"] = "$1";
  const json from = create(body);
  Worker one = worker("one");
  one.walk(one.begin().at("task"), row_steps(0, 1));
  one.walk(one.lease().at("task").at("task"), row_steps(1, 2));
  EXPECT_EQ(copy({{"name", "pilot"}}).at("status"), 409);
  EXPECT_EQ(copy({{"name", "No Name"}}).at("status"), 422);
  const json made = copy({{"name", "second"}, {"title", "The second"}});
  EXPECT_EQ(made.at("status"), 201);
  EXPECT_EQ(made.at("title"), "The second");
  EXPECT_EQ(made.at("checks"), from.at("checks"));
  EXPECT_EQ(made.at("pay"), "$1");
  EXPECT_EQ(made.at("splits"), from.at("splits"));
  EXPECT_EQ(made.at("progress").at("submitted"), 0);
  EXPECT_NE(made.at("link"), from.at("link"));
  EXPECT_NE(made.at("seed"), from.at("seed"));
  key_ = testing::key_of(made);
  EXPECT_EQ(worker("one", "second").begin().at("practice"), true);
}

TEST_F(Conditions, CollectionsAreArchivedAndFound) {
  const json pilot = create(collection_body("pilot", "write"));
  json other = collection_body("main-study", "write");
  other["title"] = "Ways through a Flat";
  create(other);
  EXPECT_THAT(listed(""), ::testing::ElementsAre("pilot", "main-study"));
  EXPECT_THAT(listed("?q=flat"), ::testing::ElementsAre("main-study"));
  EXPECT_THAT(listed("?q=PIL"), ::testing::ElementsAre("pilot"));
  EXPECT_THAT(listed("?q=%25"), ::testing::IsEmpty());
  EXPECT_EQ(change({{"state", "archived"}}).at("state"), "archived");
  EXPECT_THAT(listed(""), ::testing::ElementsAre("main-study"));
  EXPECT_THAT(listed("?state=archived"), ::testing::ElementsAre("pilot"));
  key_ = testing::key_of(pilot);
  EXPECT_EQ(worker("new").join().at("error").at("code"), "collection-closed");
  EXPECT_EQ(change({{"state", "open"}}).at("state"), "open");
  EXPECT_THAT(listed(""), ::testing::ElementsAre("pilot", "main-study"));
  EXPECT_EQ(served_.get("/api/v1/collections?state=odd", organiser_)->status, 400);
}

TEST_F(Conditions, ChangesAreForOrganisersAndAnswersForWorkers) {
  create(all_paths("write"));
  const auto status = [](const httplib::Result& result) { return result->status; };
  const char* type = "application/json";
  auto& client = served_.client();
  EXPECT_EQ(status(client.Patch("/api/v1/collections/pilot", reviewer_, "{}", type)), 403);
  EXPECT_EQ(status(client.Post("/api/v1/collections/pilot/copy", reviewer_, "{}", type)), 403);
  EXPECT_EQ(status(client.Put("/api/v1/visit/answers", organiser_, "{}", type)), 403);
  EXPECT_EQ(served_.get("/api/v1/collections/pilot/work/workers")->status, 401);
  Worker one = worker("one");
  one.join();
  EXPECT_EQ(one.put("/api/v1/visit/answers", {{"answers", 3}}).at("status"), 400);
  EXPECT_EQ(one.put("/api/v1/visit/answers", {{"answers", json::array({3})}}).at("status"), 400);
  EXPECT_EQ(one.put("/api/v1/visit/answers", {{"answers", json::array({{{"question", 1}}})}})
                .at("status"),
            400);
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
