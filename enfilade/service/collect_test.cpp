// Collecting instructions, over real sockets.
#include <gmock/gmock.h>
#include <atomic>
#include <set>

#include "tests/support/collecting.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using testing::collection_body;
using ::testing::HasSubstr;
using testing::Worker;

constexpr const char* kText = "Walk past the table and stop at the door.";

using Collect = testing::Collecting;

TEST_F(Collect, ThreeWorkersDescribeAPath) {
  create(collection_body("pilot", "write"));
  std::set<std::int64_t> tasks;
  for (const char* name : {"a", "b", "c"}) {
    Worker one = worker(name);
    const json task = one.begin();
    EXPECT_EQ(task.at("path"), json({"v0", "v1", "v2", "v3"}));
    EXPECT_EQ(task.at("scan"), "row");
    EXPECT_EQ(task.at("heading"), 1.5);
    tasks.insert(task.at("task").get<std::int64_t>());
    const json after = one.write(task.at("task"), kText);
    EXPECT_EQ(after.at("status"), 200);
    EXPECT_EQ(after.at("done"), 1);
    EXPECT_TRUE(after.at("task").is_null());
  }
  EXPECT_EQ(tasks.size(), 3U);
  Worker fourth = worker("d");
  EXPECT_TRUE(fourth.begin().is_null());
  const json nothing = fourth.lease();
  EXPECT_EQ(nothing.at("why"), "none-left");
  EXPECT_FALSE(nothing.contains("completion"));  // nothing was done
  EXPECT_EQ(progress().at("complete"), 1);
  EXPECT_EQ(progress().at("submitted"), 3);
}

TEST_F(Collect, AWorkerWhoLeavesLosesTheLeaseAndThePathIsDoneByAnother) {
  create(collection_body("pilot", "write"));
  Worker leaves = worker("leaves");
  const json abandoned = leaves.begin();
  for (const char* name : {"b", "c"}) {
    Worker one = worker(name);
    one.write(one.begin().at("task"), kText);
  }
  Worker waits = worker("waits");
  EXPECT_TRUE(waits.begin().is_null());
  EXPECT_EQ(waits.lease().at("why"), "all-leased");
  now_ += 30 * 60;
  const json task = waits.lease().at("task");
  ASSERT_TRUE(task.is_object());
  // Whoever left comes back too late: the place is another's now.
  EXPECT_EQ(leaves.write(abandoned.at("task"), kText).at("error").at("code"), "lease-expired");
  EXPECT_EQ(leaves.draft(abandoned.at("task"), json::object()).at("status"), 409);
  EXPECT_EQ(waits.write(task.at("task"), kText).at("status"), 200);
  EXPECT_EQ(progress().at("complete"), 1);
  EXPECT_EQ(progress().at("submitted"), 3);
  EXPECT_EQ(leaves.lease().at("why"), "none-left");
}

TEST_F(Collect, ALeaseThatRanOutIsStillGoodWhileNobodyElseHasThePlace) {
  create(collection_body("pilot", "write"));
  Worker slow = worker("slow");
  const json task = slow.begin();
  now_ += 2 * 3600;
  EXPECT_EQ(slow.lease().at("task").at("task"), task.at("task"));
  now_ += 2 * 3600;
  EXPECT_EQ(slow.write(task.at("task"), kText).at("status"), 200);
}

TEST_F(Collect, ADraftSurvivesAReloadAndKeepsTheLease) {
  create(collection_body("pilot", "write"));
  Worker one = worker("one");
  const json task = one.begin();
  now_ += 29 * 60;
  EXPECT_EQ(one.draft(task.at("task"), {{"text", "Walk past"}}).at("status"), 200);
  now_ += 29 * 60;
  for (const char* name : {"b", "c", "d"}) worker(name).begin();  // d finds no place
  Worker again = worker("one");
  const json held = again.join().at("visit").at("task");
  EXPECT_EQ(held.at("task"), task.at("task"));
  EXPECT_EQ(held.at("draft"), json({{"text", "Walk past"}}));
  EXPECT_EQ(again.write(task.at("task"), kText).at("status"), 200);
}

TEST_F(Collect, OneWorkerHasNoTwoPlacesOfAPath) {
  create(collection_body("pilot", "write"));
  Worker one = worker("one");
  one.write(one.begin().at("task"), kText);
  EXPECT_EQ(one.lease().at("why"), "none-left");
  Worker elsewhere = worker("one");  // the same worker in another browser
  EXPECT_TRUE(elsewhere.begin().is_null());
  Worker returns = worker("two");
  const json task = returns.begin();
  EXPECT_EQ(returns.give_back(task.at("task")).at("status"), 200);
  EXPECT_EQ(returns.lease().at("why"), "none-left");
  EXPECT_EQ(returns.write(task.at("task"), kText).at("error").at("code"), "already-returned");
  for (const char* name : {"three", "four"}) EXPECT_TRUE(worker(name).begin().is_object());
}

TEST_F(Collect, HandingInTwiceIsOnce) {
  create(collection_body("pilot", "write"));
  Worker one = worker("one");
  const auto id = one.begin().at("task").get<std::int64_t>();
  EXPECT_EQ(one.write(id, kText).at("done"), 1);
  EXPECT_EQ(one.write(id, kText).at("done"), 1);  // its answer was lost, say
  EXPECT_EQ(one.write(id, "Something else, as long.").at("error").at("code"), "already-submitted");
  EXPECT_EQ(one.give_back(id).at("error").at("code"), "already-submitted");
  const json work = served_.json("/api/v1/collections/pilot/work", organiser_);
  EXPECT_EQ(work.at("matching"), 1);
  EXPECT_EQ(work.at("work").at(0).at("instruction"), kText);
  EXPECT_EQ(work.at("work").at(0).at("page_seconds"), 42.5);
}

TEST_F(Collect, WhatIsHandedInIsChecked) {
  create(collection_body("pilot", "write"));
  Worker one = worker("one");
  const json task = one.begin();
  for (const char* text : {"", "Go there.", "Gothereandthenon", "   \n  ", "go to the d\x01oor"}) {
    EXPECT_EQ(one.write(task.at("task"), text).at("status"), 422) << text;
  }
  EXPECT_EQ(one.write(task.at("task"), std::string(2001, 'a') + " b c").at("status"), 422);
  const std::string target = "/api/v1/tasks/" + task.at("task").dump() + "/submission";
  const json faulty =
      one.put(target, {{"instruction", kText}, {"seconds", -1}, {"flags", {"short", "invented"}}});
  EXPECT_EQ(faulty.at("status"), 422);
  EXPECT_EQ(faulty.at("error").at("diagnostic_count"), 2);
  EXPECT_THAT(faulty.dump(), HasSubstr("$.flags[1]"));
  EXPECT_EQ(one.visit().at("done"), 0);
}

TEST_F(Collect, ConsentComesBeforeAnyTask) {
  create(collection_body("pilot", "write"));
  Worker one = worker("one");
  EXPECT_EQ(one.join().at("visit").at("consented"), false);
  EXPECT_EQ(one.lease().at("error").at("code"), "consent-required");
  EXPECT_EQ(one.consent().at("consented"), true);
  EXPECT_TRUE(one.lease().at("task").is_object());
}

TEST_F(Collect, AClosedCollectionTakesWhatIsOut) {
  create(collection_body("pilot", "write"));
  Worker one = worker("one");
  const json task = one.begin();
  const auto closed = served_.client().Patch("/api/v1/collections/pilot", organiser_,
                                             R"({"state": "closed"})", "application/json");
  EXPECT_EQ(closed->status, 200);
  EXPECT_EQ(worker("two").join().at("error").at("code"), "collection-closed");
  Worker again = worker("one");
  EXPECT_EQ(again.join().at("status"), 200);
  EXPECT_EQ(one.write(task.at("task"), kText).at("status"), 200);
  EXPECT_EQ(again.lease().at("why"), "closed");
}

TEST_F(Collect, PathsMayComeWithTheCollection) {
  json body = collection_body("pilot", "write");
  const json path{{"path_id", 7},         {"scan", "row"},   {"heading", 0.25},
                  {"path", {"v4", "v3"}}, {"distance", 1.0}, {"instructions", json::array()}};
  body["sources"] = json::array({{{"split", "mine"}, {"paths", json::array({path})}}});
  EXPECT_EQ(create(body).at("splits"),
            json::array({{{"split", "mine"}, {"items", 1}, {"goals_hidden", false}}}));
  EXPECT_EQ(worker("one").begin().at("path"), json({"v4", "v3"}));
}

TEST_F(Collect, EveryFaultOfACollectionIsShown) {
  json body = collection_body("No Name", "write");
  const json path{{"path_id", 7},
                  {"scan", "row"},
                  {"heading", 0},
                  {"path", {"v4", "v2"}},
                  {"instructions", json::array()}};
  body["sources"] =
      json::array({{{"split", "mine"}, {"paths", json::array({path})}}, {{"split", "test"}}});
  body["per_item"] = 0;
  body["platform"] = {{"kind", "prolific"}};
  const json refused = create(body);
  EXPECT_EQ(refused.at("status"), 422);
  const std::string said = refused.dump();
  EXPECT_THAT(said, HasSubstr("$.name"));
  EXPECT_THAT(said, HasSubstr("$.per_item"));
  EXPECT_THAT(said, HasSubstr("$.platform.completion_code"));
  EXPECT_THAT(said, HasSubstr("$.sources[0].paths[0].path[1]"));
  EXPECT_THAT(said, HasSubstr("$.sources[1].split"));  // its goals are hidden
  EXPECT_EQ(create(collection_body("pilot", "write")).at("status"), 201);
  EXPECT_EQ(create(collection_body("pilot", "write")).at("status"), 409);
}

TEST_F(Collect, MisspelledFieldsAreRefused) {
  json body = collection_body("pilot", "write");
  body["tasks_per_vist"] = 3;
  EXPECT_THAT(create(body).dump(), HasSubstr("the nearest is \\\"tasks_per_visit\\\""));
  body = collection_body("pilot", "write");
  body["sources"][0]["practise"] = true;
  EXPECT_THAT(create(body).dump(), HasSubstr("the nearest is \\\"practice\\\""));
  body = collection_body("pilot", "write");
  body["platform"] = {{"kind", "mturk"}, {"origin", json::array()}};
  EXPECT_THAT(create(body).dump(), HasSubstr("the nearest is \\\"origins\\\""));
  EXPECT_EQ(create(collection_body("pilot", "write")).at("status"), 201);
  const auto changed = served_.client().Patch("/api/v1/collections/pilot", organiser_,
                                              R"({"stat": "closed"})", "application/json");
  EXPECT_EQ(changed->status, 422);
  EXPECT_THAT(changed->body, HasSubstr("the nearest is \\\"state\\\""));
}

TEST_F(Collect, StrangersSeeATitleAndNoKey) {
  create(collection_body("pilot", "write"));
  const json seen = served_.json("/api/v1/collections/pilot");
  EXPECT_EQ(seen.at("title"), "A title");
  for (const char* field : {"link", "progress", "splits"}) EXPECT_FALSE(seen.contains(field));
  const json reviewer =
      served_.json("/api/v1/collections/pilot", served_.staff(TokenRole::kReviewer));
  EXPECT_TRUE(reviewer.contains("progress"));
  EXPECT_FALSE(reviewer.contains("link"));
}

TEST_F(Collect, ALinkWithoutANameMakesAWorkerWhoCanComeBack) {
  create(collection_body("pilot", "write"));
  Worker one(served_.port(), "pilot", {{"key", key_}});
  const auto name = one.join().at("worker").get<std::string>();
  EXPECT_EQ(name.size(), 34U);
  one.consent();
  const json task = one.lease().at("task");
  Worker again = worker(name);
  EXPECT_EQ(again.join().at("visit").at("task").at("task"), task.at("task"));
}

// Stand-ins of the platforms: what their documents say that they send, and what they take.

const json kTurk{{"assignmentId", "3ASSIGN"},
                 {"hitId", "3HIT"},
                 {"workerId", "A1WORKER"},
                 {"turkSubmitTo", "https://workersandbox.mturk.com"}};

TEST_F(Collect, MechanicalTurkPreviewsThenSendsAWorkerAndTakesTheForm) {
  json body = collection_body("pilot", "write");
  body["platform"] = {{"kind", "mturk"}};
  create(body);
  const json preview =
      come({{"assignmentId", "ASSIGNMENT_ID_NOT_AVAILABLE"}, {"hitId", "3HIT"}}).join();
  EXPECT_EQ(preview.at("preview"), true);
  EXPECT_FALSE(preview.contains("token"));
  EXPECT_EQ(preview.at("example").at("path").size(), 4U);
  Worker one = come(kTurk);
  const json done = one.write(one.begin().at("task"), kText);
  EXPECT_EQ(done.at("finished"), true);
  const json& completion = done.at("completion");
  EXPECT_EQ(completion.at("action"), "https://workersandbox.mturk.com/mturk/externalSubmit");
  EXPECT_EQ(completion.at("fields").at("assignmentId"), "3ASSIGN");
  EXPECT_GT(completion.at("fields").size(), 1U);  // MTurk wants more than the assignment
  EXPECT_EQ(one.lease().at("why"), "finished");
  // The page again, after the form was lost: the same visit, and the same form.
  EXPECT_EQ(come(kTurk).join().at("visit").at("completion"), completion);
}

TEST_F(Collect, AMechanicalTurkWorkerTakesAnotherAssignment) {
  json body = collection_body("pilot", "write");
  body["platform"] = {{"kind", "mturk"}};
  body["sources"] = json::array({{{"split", "val_seen"}}});
  create(body);
  Worker first = come(kTurk);
  json second = kTurk;
  second["assignmentId"] = "3OTHER";
  Worker other = come(second);
  const json a = first.begin();
  const json b = other.begin();
  EXPECT_NE(a.at("path"), b.at("path"));
  EXPECT_EQ(other.write(b.at("task"), kText).at("completion").at("fields").at("assignmentId"),
            "3OTHER");
  EXPECT_EQ(other.write(a.at("task"), kText).at("status"), 404);
  EXPECT_EQ(first.write(a.at("task"), kText).at("completion").at("fields").at("assignmentId"),
            "3ASSIGN");
}

TEST_F(Collect, MechanicalTurksParametersAreNotBelieved) {
  json body = collection_body("pilot", "write");
  body["platform"] = {{"kind", "mturk"}};
  create(body);
  json parameters = kTurk;
  parameters["turkSubmitTo"] = "https://evil.example";
  EXPECT_EQ(come(parameters).join().at("status"), 422);
  parameters["turkSubmitTo"] = "https://www.mturk.com/";
  EXPECT_EQ(come(parameters).join().at("status"), 200);
  parameters["workerId"] = "A2WORKER";
  EXPECT_EQ(come(parameters).join().at("error").at("code"), "conflict");
  parameters["workerId"] = "<script>";
  EXPECT_EQ(come(parameters).join().at("status"), 422);
}

TEST_F(Collect, OnlyMechanicalTurkMayFrameItsPages) {
  json body = collection_body("pilot", "write");
  body["platform"] = {{"kind", "mturk"}, {"origins", {"http://127.0.0.1:9999"}}};
  create(body);
  create(collection_body("other", "write"));
  json third = body;
  third["name"] = "third";
  third["platform"]["origins"] = {"https://a.example; script-src *"};
  EXPECT_EQ(create(third).at("status"), 422);
  if (served_.get("/collect")->status != 200) GTEST_SKIP() << "this build has no page /collect";
  const auto framed = served_.get("/collect?collection=pilot");
  EXPECT_FALSE(framed->has_header("X-Frame-Options"));
  EXPECT_THAT(framed->get_header_value("Content-Security-Policy"),
              HasSubstr("form-action 'self' http://127.0.0.1:9999; frame-ancestors "
                        "http://127.0.0.1:9999"));
  for (const char* target : {"/collect?collection=other", "/collect", "/submit?collection=pilot"}) {
    EXPECT_EQ(served_.get(target)->get_header_value("X-Frame-Options"), "DENY") << target;
  }
}

TEST_F(Collect, ProlificSendsIdsAndGetsItsCode) {
  json body = collection_body("pilot", "write");
  body["platform"] = {{"kind", "prolific"}, {"completion_code", "C1ABC2DE"}};
  body["tasks_per_visit"] = 2;
  body["sources"] = json::array({{{"split", "val_seen"}}});
  EXPECT_THAT(create(body).at("link").get<std::string>(),
              HasSubstr("PROLIFIC_PID={{%PROLIFIC_PID%}}"));
  Worker one = come(
      {{"PROLIFIC_PID", "5f0c00000000000000000001"}, {"STUDY_ID", "60aa"}, {"SESSION_ID", "60bb"}});
  json visit = one.write(one.begin().at("task"), kText);
  EXPECT_EQ(visit.at("finished"), false);
  EXPECT_FALSE(visit.contains("completion"));  // no pay for half of it
  visit = one.write(one.lease().at("task").at("task"), kText);
  EXPECT_EQ(visit.at("completion").at("code"), "C1ABC2DE");
  EXPECT_EQ(visit.at("completion").at("url"),
            "https://app.prolific.com/submissions/complete?cc=C1ABC2DE");
  const json visits = served_.json("/api/v1/collections/pilot/workers", organiser_).at("visits");
  ASSERT_EQ(visits.size(), 1U);
  EXPECT_EQ(visits[0].at("external"), "5f0c00000000000000000001");
  EXPECT_EQ(visits[0].at("submitted"), 2);
  EXPECT_EQ(visits[0].at("finished"), true);
  EXPECT_THAT(served_.get("/api/v1/collections/pilot/workers?format=csv", organiser_)->body,
              HasSubstr("\"5f0c00000000000000000001\",\"60bb\",\"60aa\""));
}

TEST_F(Collect, ProlificsLinkWithoutIdsIsAPreview) {
  json body = collection_body("pilot", "write");
  body["platform"] = {{"kind", "prolific"}, {"completion_code", "C1ABC2DE"}};
  create(body);
  for (const json& bare :
       {json::object(), json{{"PROLIFIC_PID", ""}, {"STUDY_ID", ""}, {"SESSION_ID", ""}},
        json{{"PROLIFIC_PID", "{{%PROLIFIC_PID%}}"},
             {"STUDY_ID", "{{%STUDY_ID%}}"},
             {"SESSION_ID", "{{%SESSION_ID%}}"}}}) {
    const json joined = come(bare).join();
    EXPECT_EQ(joined.at("status"), 200) << bare;
    EXPECT_EQ(joined.at("preview"), true) << bare;
    EXPECT_TRUE(joined.contains("example")) << bare;
    EXPECT_FALSE(joined.contains("token")) << bare;
  }
  // A worker whose link lost a part works for nothing in a preview: that is an error.
  EXPECT_EQ(come({{"PROLIFIC_PID", "5f0c"}, {"STUDY_ID", "60aa"}}).join().at("status"), 422);
  EXPECT_EQ(come({{"STUDY_ID", "60aa"}, {"SESSION_ID", "60bb"}}).join().at("status"), 422);
  EXPECT_EQ(served_.json("/api/v1/collections/pilot/workers", organiser_).at("visits").size(), 0U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
