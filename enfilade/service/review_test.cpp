// Reviewing and taking home what workers wrote, over real sockets.
#include <fmt/format.h>
#include <gmock/gmock.h>

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
