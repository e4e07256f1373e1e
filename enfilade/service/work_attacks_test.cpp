// What people might try against collections, and what they get. docs/threats.md has the
// table.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "tests/support/collecting.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using testing::collection_body;
using ::testing::HasSubstr;
using testing::key_of;
using ::testing::Not;
using testing::read_answer;
using testing::row_results;
using testing::row_steps;
using testing::Worker;

constexpr const char* kText = "Walk past the table and stop at the door.";

using WorkAttacks = testing::Collecting;

TEST_F(WorkAttacks, AnotherWorkersTaskIsNotThere) {
  create(collection_body("pilot", "write"));
  Worker owner = worker("owner");
  Worker thief = worker("thief");
  const auto task = owner.begin().at("task").get<std::int64_t>();
  thief.begin();
  EXPECT_EQ(thief.task(task).at("status"), 404);
  EXPECT_EQ(thief.write(task, kText).at("status"), 404);
  EXPECT_EQ(thief.draft(task, {{"text", "mine"}}).at("status"), 404);
  EXPECT_EQ(thief.give_back(task).at("status"), 404);
  EXPECT_EQ(owner.write(task, kText).at("status"), 200);
  EXPECT_EQ(thief.task(task).at("status"), 404);
}

TEST_F(WorkAttacks, ForgedTaskIdsAreNotThere) {
  create(collection_body("pilot", "write"));
  Worker one = worker("one");
  one.begin();
  const json body{{"instruction", kText}};
  for (const char* id :
       {"0", "-1", "2", "99999999999999999999", "1%20OR%201=1", "1'--", "x", "1x", "1.0"}) {
    const std::string target = std::string("/api/v1/tasks/") + id;
    EXPECT_EQ(one.put(target + "/submission", body).at("status"), 404) << id;
    EXPECT_EQ(served_.get(target, organiser_)->status, 404) << id;
  }
  EXPECT_EQ(served_.get("/api/v1/tasks/%00", organiser_)->status, 400) << "never reaches a route";
}

TEST_F(WorkAttacks, RolesKeepToTheirs) {
  create(collection_body("pilot", "write"));
  Worker one = worker("one");
  const auto id = one.begin().at("task").get<std::int64_t>();
  one.write(id, kText);
  const std::string task = "/api/v1/tasks/" + std::to_string(id);
  const auto team = served_.team("A team");
  served_.submit(team, "open", row_results(3));
  const auto worker_headers = one.headers();
  const auto status = [this](const std::string& target, const httplib::Headers& who) {
    return served_.get(target, who)->status;
  };
  for (const auto& who : {worker_headers, team}) {
    EXPECT_EQ(status("/api/v1/collections", who), 403);
    EXPECT_EQ(status("/api/v1/collections/pilot/work", who), 403);
    EXPECT_EQ(put(task + "/review", who, {{"verdict", "accepted"}}).at("status"), 403);
    EXPECT_EQ(put(task + "/instruction", who, {{"instruction", kText}}).at("status"), 403);
  }
  for (const auto& who : {worker_headers, team, reviewer_}) {
    EXPECT_EQ(status("/api/v1/collections/pilot/workers", who), 403);
    EXPECT_EQ(status("/api/v1/collections/pilot/export?split=val_seen", who), 403);
    EXPECT_EQ(read_answer(served_.client().Post("/api/v1/collections", who,
                                                collection_body("own", "write").dump(),
                                                "application/json"))
                  .at("status"),
              403);
  }
  for (const auto& who : {worker_headers, reviewer_}) {  // they have no team: not everybody's
    EXPECT_EQ(status("/api/v1/submissions", who), 403);
    EXPECT_EQ(status("/api/v1/submissions/1", who), 404);
    EXPECT_EQ(status("/api/v1/leaderboards/final", who), 403);
    EXPECT_EQ(served_.submit(who, "open", row_results(3))->status, 403);
  }
  EXPECT_EQ(status(task, team), 404);
  EXPECT_EQ(status(task, {}), 401);
  EXPECT_EQ(status("/api/v1/visit", organiser_), 403);
  // A worker's token makes no cookie, which other sites could send.
  const std::string token = worker_headers.find("Authorization")->second.substr(7);
  EXPECT_EQ(served_.client()
                .Post("/api/v1/session", json{{"token", token}}.dump(), "application/json")
                ->status,
            403);
}

TEST_F(WorkAttacks, AnotherSiteCannotUseAnOrganisersCookie) {
  create(collection_body("pilot", "write"));
  const std::string token = organiser_.find("Authorization")->second.substr(7);
  const auto in =
      served_.client().Post("/api/v1/session", json{{"token", token}}.dump(), "application/json");
  const std::string set = in->get_header_value("Set-Cookie");
  const std::string cookie = set.substr(0, set.find(';'));
  const auto close = [&](const httplib::Headers& headers) {
    return served_.client()
        .Patch("/api/v1/collections/pilot", headers, R"({"state": "closed"})", "application/json")
        ->status;
  };
  EXPECT_EQ(close({{"Cookie", cookie}}), 403);
  EXPECT_EQ(close({{"Cookie", cookie}, {"X-Enfilade", "1"}}), 200);
}

TEST_F(WorkAttacks, ALinkNeedsItsKeyAndGuessingIsSlow) {
  create(collection_body("pilot", "write"));
  const std::string key = key_;
  const auto guess = [&](const json& guessed) {
    return Worker(served_.port(), "pilot", {{"key", guessed}}).join().at("status").get<int>();
  };
  EXPECT_EQ(guess("0123456789abcdef0123456789abcdef"), 403);
  EXPECT_EQ(guess(""), 403);
  EXPECT_EQ(guess(3), 400);
  EXPECT_EQ(guess("' OR 1=1 --"), 403);
  int status = 403;
  for (int k = 0; k < 20 && status == 403; ++k) status = guess(std::to_string(k));
  EXPECT_EQ(status, 429);
  EXPECT_EQ(guess(key), 200);
}

TEST_F(WorkAttacks, WorkersTokensExpire) {
  create(collection_body("pilot", "write"));
  Worker one = worker("one");
  const auto task = one.begin().at("task").get<std::int64_t>();
  now_ += 24 * 3600;
  EXPECT_EQ(one.write(task, kText).at("status"), 401);
  one.join();
  EXPECT_EQ(one.write(task, kText).at("status"), 200);
}

TEST_F(WorkAttacks, SqlInAnyFieldIsText) {
  const std::string evil = "x'); DROP TABLE task; --";
  json body = collection_body("pilot", "write");
  body["title"] = evil;
  body["consent"] = evil;
  body["instructions"] = evil;
  create(body);
  Worker one = worker(evil);
  const auto task = one.begin().at("task").get<std::int64_t>();
  EXPECT_EQ(one.draft(task, {{evil, evil}}).at("status"), 200);
  EXPECT_EQ(one.task(task).at("draft"), json({{evil, evil}}));
  EXPECT_EQ(one.write(task, evil).at("status"), 200);
  const std::string target = "/api/v1/tasks/" + std::to_string(task);
  EXPECT_EQ(
      put(target + "/review", reviewer_, {{"verdict", "rejected"}, {"reason", evil}}).at("reason"),
      evil);
  EXPECT_EQ(
      put(target + "/instruction", reviewer_, {{"instruction", evil + evil}}).at("instruction"),
      evil + evil);
  EXPECT_EQ(served_.json("/api/v1/collections/pilot").at("title"), evil);
  for (const char* query : {"?state=all'--", "?state='", "?after=1'"}) {
    EXPECT_EQ(
        served_.get("/api/v1/collections/pilot/work" + std::string(query), organiser_)->status,
        400);
  }
  for (const char* name : {"pilot'--", "%27%20OR%201=1--"}) {
    EXPECT_EQ(served_.get("/api/v1/collections/" + std::string(name))->status, 404) << name;
  }
  EXPECT_EQ(served_.get("/api/v1/collections/pilot/export?split=val_seen'--", organiser_)->status,
            404);
  EXPECT_EQ(progress().at("rejected"), 1);
}

TEST_F(WorkAttacks, ScriptsComeBackAsTextOfATypeThatRunsNothing) {
  const std::string script = "<script>alert(1)</script> <img src=x onerror=alert(2)>";
  json body = collection_body("pilot", "write");
  body["title"] = script;
  body["consent"] = script + " [a](javascript:alert(1))";
  create(body);
  Worker one = worker(script);
  const auto task = one.begin().at("task").get<std::int64_t>();
  EXPECT_EQ(one.write(task, "Go to the " + script).at("status"), 200);
  for (const std::string target : {"/api/v1/collections/pilot", "/api/v1/collections/pilot/work",
                                   "/api/v1/collections/pilot/workers",
                                   "/api/v1/collections/pilot/export?split=val_seen&state=all"}) {
    const auto result = served_.get(target, organiser_);
    EXPECT_EQ(result->get_header_value("Content-Type"), "application/json") << target;
    EXPECT_EQ(result->get_header_value("X-Content-Type-Options"), "nosniff") << target;
    EXPECT_THAT(result->get_header_value("Content-Security-Policy"),
                HasSubstr("default-src 'none'"));
  }
}

TEST_F(WorkAttacks, AFormulaForANameIsQuotedInTheSheet) {
  create(collection_body("pilot", "write"));
  worker("=HYPERLINK(1)").begin();
  EXPECT_THAT(served_.get("/api/v1/collections/pilot/workers?format=csv", organiser_)->body,
              HasSubstr("\"'=HYPERLINK(1)\""));
}

TEST_F(WorkAttacks, OversizedBodiesAreRefused) {
  create(collection_body("pilot", "walk"));
  Worker one = worker("one");
  const auto task = one.begin().at("task").get<std::int64_t>();
  EXPECT_EQ(one.draft(task, {{"text", std::string(300'000, 'a')}}).at("status"), 413);
  EXPECT_EQ(one.walk(task, std::string(1'100'000, 'a')).at("status"), 413);
  json steps = row_steps(0, 0);
  for (int k = 0; k < 5000; ++k) steps.push_back(steps[0]);
  EXPECT_EQ(one.walk(task, steps).at("status"), 422);
  EXPECT_EQ(one.put("/api/v1/visit/consent", std::string(20'000, 'a')).at("status"), 413);
  const auto large = Worker(served_.port(), "pilot", {{"key", std::string(50'000, 'a')}}).join();
  EXPECT_EQ(large.at("status"), 413);
}

// The one was 120,000 calls deep to write again, the other took five seconds to read.
TEST_F(WorkAttacks, DraftsThatAreDeepOrWideDoNoHarm) {
  create(collection_body("pilot", "write"));
  Worker one = worker("one");
  const auto task = one.begin().at("task").get<std::int64_t>();
  const auto put_draft = [&](const std::string& draft) {
    const auto result =
        served_.client().Put(fmt::format("/api/v1/tasks/{}/draft", task), one.headers(),
                             "{\"draft\": {" + draft + "}}", "application/json");
    return result ? result->status : 0;
  };
  for (const int depth : {100, 120'000}) {
    const auto times = static_cast<std::size_t>(depth);
    EXPECT_EQ(put_draft("\"a\": " + std::string(times, '[') + std::string(times, ']')), 400);
  }
  std::string names;
  for (int k = 0; k < 28'000; ++k) names += fmt::format("{}\"{:x}\":1", k == 0 ? "" : ",", k);
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(put_draft(names), 200);
  EXPECT_EQ(one.task(task).at("draft").size(), 28'000U);
  // Half a second where it was nine: a sanitizer and a busy machine take their share.
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(5));
  EXPECT_EQ(put_draft(R"("text": "Walk", "text": "Walk on", "a": 1e999)"), 400);
  EXPECT_EQ(put_draft(R"("text": "Walk", "text": "Walk on")"), 200);
  EXPECT_EQ(one.task(task).at("draft"), json({{"text", "Walk on"}}));
}

TEST_F(WorkAttacks, BodiesOfTheWrongShapeAreRefused) {
  create(collection_body("pilot", "write"));
  Worker one = worker("one");
  const auto task = one.begin().at("task").get<std::int64_t>();
  const std::string target = "/api/v1/tasks/" + std::to_string(task);
  for (const json& body :
       {json(nullptr), json(3), json("x"), json::array(), json::object(), json{{"instruction", 3}},
        json{{"instruction", nullptr}}, json{{"draft", 3}}, json{{"verdict", json::array()}}}) {
    for (const char* part : {"/submission", "/draft"}) {
      const auto status = one.put(target + part, body).at("status").get<int>();
      EXPECT_TRUE(status == 400 || status == 422) << part << body << status;
    }
    for (const char* part : {"/review", "/instruction"}) {
      EXPECT_EQ(put(target + part, reviewer_, body).at("status"), 400) << part << body;
    }
    const auto made = create(body).at("status").get<int>();
    EXPECT_EQ(made, 422) << body;
  }
  EXPECT_EQ(one.write(task, kText).at("status"), 200);
}

TEST_F(WorkAttacks, TooManyWhoComeFromAnAddressWait) {
  create(collection_body("pilot", "write"));
  served_.stop();
  ServerConfig config = served_.config();
  config.most_joins = 2;
  const Server strict(Site::open(served_.root() / "data"), config);
  const auto join = [&](const std::string& name) {
    return Worker(strict.port(), "pilot", {{"key", key_}, {"worker", name}})
        .join()
        .at("status")
        .get<int>();
  };
  EXPECT_EQ(join("a"), 200);
  EXPECT_EQ(join("b"), 200);
  EXPECT_EQ(join("c"), 429);
  now_ += 60;
  EXPECT_EQ(join("c"), 200);
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
