// Reviewing and taking home what workers wrote, over real sockets.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <string>
#include <vector>

#include "enfilade/service/collecting/quality.h"
#include "enfilade/tasks/statistics.h"
#include "tests/support/collecting.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using testing::collection_body;
using ::testing::HasSubstr;
using testing::Worker;

constexpr const char* kText = "Walk past the table and stop at the door.";

class Review : public testing::Collecting {
 protected:
  /// Has a worker write about a path. \returns the task's number
  std::int64_t written(const std::string& name, const std::string& text = kText) {
    Worker one = worker(name);
    const auto task = one.begin().at("task").get<std::int64_t>();
    one.write(task, text);
    return task;
  }
  json judge(std::int64_t task, const json& verdict) {
    return put("/api/v1/tasks/" + std::to_string(task) + "/review", reviewer_, verdict);
  }
  json correct(std::int64_t task, const std::string& text) {
    return put("/api/v1/tasks/" + std::to_string(task) + "/instruction", reviewer_,
               {{"instruction", text}});
  }
  std::string exported(const std::string& query = "") {
    return served_.get("/api/v1/collections/pilot/export?split=val_seen" + query, organiser_)->body;
  }
  int walkers_ = 0;  ///< names of workers
};

TEST_F(Review, TheQueueIsWhatWaits) {
  create(collection_body("pilot", "write"));
  const std::int64_t first = written("a");
  const std::int64_t second = written("b");
  EXPECT_EQ(judge(first, {{"verdict", "accepted"}}).at("state"), "accepted");
  const std::string target = "/api/v1/collections/pilot/work";
  const json queue = served_.json(target, reviewer_);
  EXPECT_EQ(queue.at("matching"), 1);
  EXPECT_EQ(queue.at("work").at(0).at("task"), second);
  EXPECT_EQ(served_.json(target + "?state=accepted", reviewer_).at("matching"), 1);
  const json rest =
      served_.json(target + "?state=all&limit=1&after=" + std::to_string(first), reviewer_);
  EXPECT_EQ(rest.at("matching"), 2);
  EXPECT_EQ(rest.at("work").at(0).at("task"), second);
  EXPECT_EQ(served_.get(target + "?state=odd", reviewer_)->status, 400);
}

TEST_F(Review, ARejectedOnesPlaceGoesToAnotherWorker) {
  json body = collection_body("pilot", "write");
  body["per_item"] = 1;
  create(body);
  Worker careless = worker("careless");
  const auto task = careless.begin().at("task").get<std::int64_t>();
  careless.write(task, "bla bla bla bla");
  EXPECT_TRUE(worker("next").begin().is_null());
  EXPECT_EQ(judge(task, {{"verdict", "rejected"}}).at("status"), 400);  // why?
  EXPECT_EQ(judge(task, json::object()).at("error").at("message"),
            "verdict: must be there, and a text");
  EXPECT_EQ(judge(task, {{"verdict", "rejected"}, {"reason", 7}}).at("error").at("message"),
            "reason: must be there, and a text");
  EXPECT_EQ(judge(task, {{"verdict", "rejected"}, {"reason", "No way in it."}}).at("state"),
            "rejected");
  EXPECT_EQ(careless.task(task).at("reason"), "No way in it.");
  EXPECT_EQ(careless.lease().at("why"), "none-left");
  EXPECT_TRUE(worker("next").begin().is_object());
  EXPECT_EQ(judge(task, {{"verdict", "accepted"}}).at("error").at("code"), "conflict");
}

TEST_F(Review, ACorrectionKeepsWhatStoodThere) {
  create(collection_body("pilot", "write"));
  const std::int64_t task = written("a");
  EXPECT_EQ(correct(task, "Too short").at("status"), 422);
  const json corrected = correct(task, "Walk past the table; stop at the door.");
  EXPECT_EQ(corrected.at("instruction"), "Walk past the table; stop at the door.");
  EXPECT_EQ(corrected.at("state"), "submitted");
  judge(task, {{"verdict", "accepted"}});
  const json history =
      served_.json("/api/v1/tasks/" + std::to_string(task), organiser_).at("history");
  ASSERT_EQ(history.size(), 2U);
  EXPECT_EQ(history[0].at("what"), "edited");
  EXPECT_EQ(history[0].at("before"), kText);
  EXPECT_EQ(history[0].at("who"), "reviewer");
  EXPECT_EQ(history[1].at("what"), "accepted");
  EXPECT_EQ(correct(999, kText).at("status"), 404);
}

TEST_F(Review, AcceptingKeepsTheTextAsTheReviewerLeftIt) {
  create(collection_body("pilot", "write"));
  const std::int64_t task = written("a");
  const std::string better = "Walk past the table, then stop at the door.";
  EXPECT_EQ(judge(task, {{"verdict", "accepted"}, {"instruction", "Too short"}}).at("status"), 422);
  const json judged = judge(task, {{"verdict", "accepted"}, {"instruction", better}});
  EXPECT_EQ(judged.at("state"), "accepted");
  EXPECT_EQ(judged.at("instruction"), better);
  ASSERT_EQ(judged.at("history").size(), 2U);
  EXPECT_EQ(judged.at("history")[0].at("before"), kText);
  EXPECT_THAT(exported(), HasSubstr(better));
}

TEST_F(Review, ACorrectionIsNotStoredWhereItsVerdictIsRefused) {
  json body = collection_body("pilot", "write");
  body["per_item"] = 1;
  create(body);
  const std::int64_t task = written("a");
  judge(task, {{"verdict", "rejected"}, {"reason", "No way in it."}});
  written("b");  // has the place now
  EXPECT_EQ(judge(task, {{"verdict", "accepted"}, {"instruction", "Another text, long enough."}})
                .at("status"),
            409);
  EXPECT_EQ(served_.json("/api/v1/tasks/" + std::to_string(task), reviewer_).at("instruction"),
            kText);
}

TEST_F(Review, ARejectedWorkerReadsWhyAtTheNextVisit) {
  json body = collection_body("pilot", "write");
  body["sources"] = json::array({{{"split", "val_seen"}}});
  create(body);
  const std::int64_t task = written("a");
  EXPECT_FALSE(worker("a").join().at("visit").contains("rejected"));
  judge(task, {{"verdict", "rejected"}, {"reason", "It leads elsewhere."}});
  const json rejected = worker("a").join().at("visit").at("rejected");
  ASSERT_EQ(rejected.size(), 1U);
  EXPECT_EQ(rejected[0].at("task"), task);
  EXPECT_EQ(rejected[0].at("reason"), "It leads elsewhere.");
  EXPECT_FALSE(worker("b").join().at("visit").contains("rejected"));  // nobody else's business
  judge(task, {{"verdict", "accepted"}});
  EXPECT_FALSE(worker("a").join().at("visit").contains("rejected"));
}

TEST_F(Review, WorkIsShownByWorkerAndByPath) {
  json body = collection_body("pilot", "write");
  body["sources"] = json::array({{{"split", "val_seen"}, {"most", 2}}});
  create(body);
  for (const char* name : {"a", "b"}) {
    Worker one = worker(name);
    one.join();
    one.consent();
    for (int k = 0; k < 2; ++k) {
      const auto task = one.lease().at("task").at("task").get<std::int64_t>();
      now_ += 60;
      one.write(task, kText);
    }
  }
  const std::string work = "/api/v1/collections/pilot/work";
  const json all = served_.json(work + "?state=all", reviewer_);
  EXPECT_EQ(all.at("matching"), 4);
  const auto worker_id = all.at("work")[0].at("worker").get<std::int64_t>();
  const auto path_id = all.at("work")[0].at("path_id").get<std::int64_t>();
  judge(all.at("work")[0].at("task").get<std::int64_t>(),
        {{"verdict", "rejected"}, {"reason", "Why not."}});
  const std::string of_worker = fmt::format("{}?state=all&worker={}", work, worker_id);
  EXPECT_EQ(served_.json(of_worker, reviewer_).at("matching"), 2);
  EXPECT_EQ(
      served_.json(fmt::format("{}&path_id={}", of_worker, path_id), reviewer_).at("matching"), 1);
  EXPECT_EQ(served_.json(work + "?state=all&worker=999", reviewer_).at("matching"), 0);
  EXPECT_EQ(served_.get(work + "?worker=x", reviewer_)->status, 400);
  const json workers = served_.json(work + "/workers", reviewer_).at("workers");
  ASSERT_EQ(workers.size(), 2U);
  EXPECT_EQ(workers[0].at("worker"), worker_id);
  EXPECT_EQ(workers[0].at("submitted"), 1);
  EXPECT_EQ(workers[0].at("rejected"), 1);
  EXPECT_EQ(workers[0].at("mean_seconds"), 60.0);
  EXPECT_FALSE(workers[0].contains("external"));  // whom the platform knows, reviewers do not
  const json paths = served_.json(work + "/paths?after=1", reviewer_).at("paths");
  ASSERT_EQ(paths.size(), 1U);
  EXPECT_EQ(paths[0].at("path_id"), 2);
  EXPECT_EQ(paths[0].at("submitted").get<int>() + paths[0].at("rejected").get<int>(), 2);
}

TEST_F(Review, SeveralAreJudgedTogetherOrNoneIs) {
  create(collection_body("pilot", "write"));
  create(collection_body("other", "write"));
  const std::int64_t elsewhere = worker("x", "other").begin().at("task").get<std::int64_t>();
  create(collection_body("third", "write"));
  const auto judge_all = [&](const json& body, const std::string& collection = "pilot") {
    return put("/api/v1/collections/" + collection + "/reviews", reviewer_, body);
  };
  std::vector<std::int64_t> tasks;
  key_ = testing::key_of(served_.json("/api/v1/collections/pilot", organiser_));
  for (const char* name : {"a", "b", "c"}) tasks.push_back(written(name));
  const auto state = [&](std::int64_t task) {
    return served_.json("/api/v1/tasks/" + std::to_string(task), reviewer_).at("state");
  };
  // One is of another collection, or was not submitted: nothing is stored.
  for (const std::int64_t wrong : {elsewhere, std::int64_t{999}}) {
    const json refused =
        judge_all({{"tasks", {tasks[0], tasks[1], wrong}}, {"verdict", "accepted"}});
    EXPECT_EQ(refused.at("status"), 404);
    EXPECT_THAT(refused.dump(), HasSubstr(fmt::format("task {}", wrong)));
  }
  EXPECT_EQ(judge_all({{"tasks", tasks}, {"verdict", "accepted"}}, "third").at("status"), 404);
  EXPECT_EQ(state(tasks[0]), "submitted");
  EXPECT_EQ(judge_all({{"tasks", tasks}, {"verdict", "rejected"}}).at("status"), 400);
  EXPECT_EQ(judge_all({{"tasks", json::array()}, {"verdict", "accepted"}}).at("status"), 400);
  EXPECT_EQ(judge_all({{"tasks", {"1"}}, {"verdict", "accepted"}}).at("status"), 400);
  EXPECT_EQ(judge_all({{"tasks", json(501, 1)}, {"verdict", "accepted"}}).at("status"), 400);
  EXPECT_EQ(put("/api/v1/collections/pilot/reviews", {}, {{"tasks", tasks}}).at("status"), 401);

  const json judged = judge_all({{"tasks", tasks}, {"verdict", "accepted"}});
  EXPECT_EQ(judged.at("status"), 200) << judged;
  EXPECT_EQ(judged.at("reviewed"), 3);
  EXPECT_EQ(judged.at("collection").at("progress").at("accepted"), 3);
  for (const std::int64_t task : tasks) {
    const json work = served_.json("/api/v1/tasks/" + std::to_string(task), reviewer_);
    EXPECT_EQ(work.at("state"), "accepted");
    ASSERT_EQ(work.at("history").size(), 1U);  // as of one by one
    EXPECT_EQ(work.at("history")[0].at("who"), "reviewer");
    EXPECT_EQ(work.at("history")[0].at("what"), "accepted");
  }
  EXPECT_EQ(judge_all({{"tasks", {tasks[0], tasks[1]}},
                       {"verdict", "rejected"},
                       {"reason", "Of another path."}})
                .at("status"),
            200);
  EXPECT_EQ(state(tasks[1]), "rejected");
  // Another worker has the place of one of them: neither comes back.
  written("d");
  written("e");
  EXPECT_EQ(judge_all({{"tasks", {tasks[0], tasks[1]}}, {"verdict", "accepted"}}).at("status"),
            409);
  EXPECT_EQ(state(tasks[0]), "rejected");
}

TEST_F(Review, TextsAreSearched) {
  create(collection_body("pilot", "write"));
  written("a", "Leave the kitchen and stop at the SOFA.");
  const std::int64_t second = written("b", "Walk to 100% of the sofa, please.");
  written("c", "Stop beside the bed.");
  const auto found = [&](const std::string& query) {
    return served_.json("/api/v1/collections/pilot/work?state=all&q=" + query, reviewer_);
  };
  EXPECT_EQ(found("sofa").at("matching"), 2);
  EXPECT_EQ(found("SOFA&limit=1").at("work").size(), 1U);
  EXPECT_EQ(found("sofa&limit=1").at("matching"), 2);
  const json rest = found("sofa&after=" + std::to_string(second - 1));
  ASSERT_EQ(rest.at("work").size(), 1U);
  EXPECT_EQ(rest.at("work")[0].at("task"), second);
  EXPECT_EQ(found("100%25").at("matching"), 1);  // a character like others
  EXPECT_EQ(found("_").at("matching"), 0);
  judge(second, {{"verdict", "accepted"}});
  EXPECT_EQ(served_.json("/api/v1/collections/pilot/work?q=sofa", reviewer_).at("matching"), 1);
  create(collection_body("walks", "walk"));
  Worker one = worker("w", "walks");
  const json task = one.begin();
  ASSERT_EQ(one.walk(task.at("task"), testing::row_steps(0, 3)).at("status"), 200);
  const auto walks = [&](const std::string& text) {
    const std::string target =
        httplib::append_query_params("/api/v1/collections/walks/work", {{"q", text}});
    return served_.json(target, reviewer_).at("matching");
  };
  EXPECT_EQ(walks(task.at("instruction").get<std::string>()), 1);  // that was followed
  EXPECT_EQ(walks("v3"), 0);                                       // not the steps
}

TEST_F(Review, TokensOfTwoTextsAreCompared) {
  using collecting::token_f1;
  EXPECT_EQ(token_f1("Turn left at the sofa.", "turn LEFT at the sofa!"), 1.0);
  EXPECT_EQ(token_f1("Turn left.", "Go on"), 0.0);
  EXPECT_EQ(token_f1("", "Go on"), 0.0);
  EXPECT_EQ(token_f1("?!", "?!"), 0.0);  // no word in it
  EXPECT_DOUBLE_EQ(token_f1("go go left", "go right"), 2.0 * 1 / 5);
  EXPECT_DOUBLE_EQ(token_f1("go right", "go go left"), 2.0 * 1 / 5);
  EXPECT_GT(token_f1("\xE0\xA4\xAC\xE0\xA4\xBE", "\xE0\xA4\xAC\xE0\xA4\xBE"), 0.99);  // Hindi
}

TEST_F(Review, WorkersAgreeAsFarAsTheirTextsDo) {
  json body = collection_body("pilot", "write");
  body["sources"] = json::array({{{"split", "val_seen"}, {"most", 2}}});
  create(body);
  const auto quality = [&](const httplib::Headers& who) {
    return served_.json("/api/v1/collections/pilot/quality", who);
  };
  EXPECT_TRUE(quality(reviewer_).at("agreement").at("mean").is_null());
  EXPECT_EQ(quality(reviewer_).at("questions"), json::array());
  for (const char* name : {"a", "b"}) {
    Worker one = worker(name);
    one.join();
    one.consent();
    for (int k = 0; k < 2; ++k) {
      const json task = one.lease().at("task");
      const bool first = task.at("path")[0] == "v0";
      const bool a = name == std::string("a");
      one.write(task.at("task"), first ? (a ? "walk on to the red sofa" : "walk on to the bed now")
                                       : "stop here please");
    }
  }
  const json agreement = quality(reviewer_).at("agreement");
  EXPECT_EQ(agreement.at("measure"), "token-f1");
  EXPECT_EQ(agreement.at("items"), 2);
  EXPECT_EQ(agreement.at("pairs"), 2);
  const double alike = 2.0 * 4 / 12;  // walk, on, to, the
  EXPECT_DOUBLE_EQ(agreement.at("mean").get<double>(), (alike + 1) / 2);
  EXPECT_EQ(agreement.at("others"), 0.0);
  ASSERT_EQ(agreement.at("least").size(), 2U);
  EXPECT_EQ(agreement.at("least")[0].at("path_id"), 1);
  EXPECT_DOUBLE_EQ(agreement.at("least")[0].at("value").get<double>(), alike);
  // What is rejected does not count.
  const json all = served_.json("/api/v1/collections/pilot/work?state=all&path_id=1", reviewer_);
  judge(all.at("work")[0].at("task").get<std::int64_t>(),
        {{"verdict", "rejected"}, {"reason", "Why not."}});
  EXPECT_EQ(quality(organiser_).at("agreement").at("items"), 1);
}

TEST_F(Review, WalkersAgreeAsFarAsTheirOutcomesDo) {
  json body = collection_body("pilot", "walk");
  body["per_item"] = 3;
  body["sources"][0] = {{"split", "train"}, {"paths", json::array()}};
  body["sources"][0]["paths"].push_back({{"path_id", 1},
                                         {"scan", "row"},
                                         {"heading", 0},
                                         {"path", {"v0", "v1", "v2", "v3", "v4", "v5"}},
                                         {"instructions", {"Walk to the end of the hall."}}});
  ASSERT_EQ(create(body).at("status"), 201);
  for (const int last : {5, 5, 0}) {
    Worker one = worker("to " + std::to_string(last) + std::to_string(++walkers_));
    one.walk(one.begin().at("task"), testing::row_steps(0, last));
  }
  const json agreement =
      served_.json("/api/v1/collections/pilot/quality", reviewer_).at("agreement");
  EXPECT_EQ(agreement.at("measure"), "same-outcome");
  EXPECT_EQ(agreement.at("pairs"), 3);
  EXPECT_DOUBLE_EQ(agreement.at("mean").get<double>(), 1.0 / 3);
  EXPECT_DOUBLE_EQ(agreement.at("success").get<double>(), 2.0 / 3);
  EXPECT_GT(agreement.at("metres").get<double>(), 3.0);
}

// A reviewer is not told who reached a secret goal, nor how many did.
TEST_F(Review, AgreementOnSecretGoalsIsTheOrganisersAlone) {
  json body = collection_body("pilot", "walk");
  body["per_item"] = 2;
  body["sources"] = json::array({{{"split", "test"}}});
  ASSERT_EQ(create(body).at("status"), 201);
  for (const char* name : {"a", "b"}) {
    Worker one = worker(name);
    for (json task = one.begin(); task.is_object(); task = one.lease().at("task")) {
      json step = testing::row_steps(0, 0)[0];
      step["viewpoint"] = task.at("start");
      ASSERT_EQ(one.walk(task.at("task"), json::array({step})).at("status"), 200);
    }
  }
  const std::string target = "/api/v1/collections/pilot/quality";
  EXPECT_EQ(served_.json(target, organiser_).at("agreement").at("items"), 6);
  const json told = served_.json(target, reviewer_).at("agreement");
  EXPECT_EQ(told.at("items"), 0);
  EXPECT_TRUE(told.at("success").is_null());
}

TEST_F(Review, AnswersToQuestionsAreCounted) {
  json body = collection_body("pilot", "write");
  body["checks"] = json::parse(R"([{"question": "Which is blue?", "choices": ["Red", "Blue"],
                                    "accept": ["Blue"]}])");
  body["check_every"] = 1;
  create(body);
  for (const char* choice : {"Red", "Blue", "Blue"}) {
    Worker one = worker(std::string("w") + std::to_string(++walkers_));
    one.join();
    const auto question = one.consent().at("questions")[0].at("question").get<std::int64_t>();
    one.put("/api/v1/visit/answers",
            {{"answers", json::array({{{"question", question}, {"choice", choice}}})}});
  }
  const std::string target = "/api/v1/collections/pilot/quality";
  const json told = served_.json(target, reviewer_).at("questions").at(0);
  EXPECT_EQ(told.at("text"), "Which is blue?");
  EXPECT_EQ(told.at("stage"), "check");
  EXPECT_EQ(told.at("answered"), 3);
  EXPECT_EQ(told.at("right"), 2);
  EXPECT_FALSE(told.contains("choices"));  // which is right is the organiser's
  EXPECT_EQ(served_.json(target, organiser_).at("questions").at(0).at("choices"),
            json::parse(R"([{"choice": "Red", "chosen": 1, "right": false},
                            {"choice": "Blue", "chosen": 2, "right": true}])"));
  EXPECT_EQ(served_.get(target)->status, 401);
}

TEST_F(Review, ProgressIsCountedByDay) {
  create(collection_body("pilot", "write"));
  EXPECT_EQ(progress().at("days"), json::array());
  const std::int64_t first = written("a");  // 1970-01-12, 13:46:40
  written("b");
  now_ += 86'400;
  judge(first, {{"verdict", "accepted"}});
  written("c");
  EXPECT_EQ(progress().at("days"),
            json::parse(R"([{"day": "1970-01-12", "submitted": 2, "reviewed": 0},
                            {"day": "1970-01-13", "submitted": 1, "reviewed": 1}])"));
}

TEST_F(Review, AWorkerWhoseAnswerWasLostMayRepeatItAfterACorrection) {
  create(collection_body("pilot", "write"));
  Worker one = worker("one");
  const auto task = one.begin().at("task").get<std::int64_t>();
  one.write(task, kText);
  correct(task, "Walk past the table; stop at the door.");
  EXPECT_EQ(one.write(task, kText).at("status"), 200);
  EXPECT_EQ(served_.json("/api/v1/tasks/" + std::to_string(task), reviewer_).at("instruction"),
            "Walk past the table; stop at the door.");
}

TEST_F(Review, AcceptedInstructionsAreExportedAsR2r) {
  create(collection_body("pilot", "write"));
  const std::int64_t first = written("a", "First: walk past the table.\nThen stop.");
  written("b", "Second: go ahead \"slowly\".");
  const std::int64_t third = written("c", "Third: \xC3\xA0 droite, puis stop.");
  EXPECT_THAT(exported(), HasSubstr("nothing to export"));
  for (const std::int64_t task : {first, third}) judge(task, {{"verdict", "accepted"}});
  const auto annotations = tasks::parse_annotations(exported(), "export", "val_seen");
  ASSERT_EQ(annotations.paths.size(), 1U);
  const tasks::PathAnnotation& path = annotations.paths[0];
  const tasks::PathAnnotation source = testing::row_annotations("val_seen", true).paths[0];
  EXPECT_EQ(path.path_id, source.path_id);
  EXPECT_EQ(path.scan, source.scan);
  EXPECT_EQ(path.heading, source.heading);
  EXPECT_EQ(path.path, source.path);
  EXPECT_EQ(path.distance, source.distance);
  EXPECT_THAT(path.instructions, ::testing::ElementsAre("First: walk past the table.\nThen stop.",
                                                        "Third: \xC3\xA0 droite, puis stop."));
  const auto all = tasks::parse_annotations(exported("&state=all"), "export", "val_seen");
  EXPECT_EQ(all.paths.at(0).instructions.size(), 3U);
  // What enfilade stats does with it.
  const std::vector<tasks::Annotations> splits{annotations};
  const auto statistics = tasks::compute_statistics(
      splits, graph::GraphSet::open(served_.root() / "data/connectivity"), 5);
  EXPECT_THAT(tasks::to_json(statistics), HasSubstr("val_seen"));
  EXPECT_EQ(served_.get("/api/v1/collections/pilot/export?split=none", organiser_)->status, 404);
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
