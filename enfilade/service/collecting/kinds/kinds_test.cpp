// Collections of descriptions of objects, of guides and of dialogues, over real sockets.
#include <gmock/gmock.h>

#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/file_tree.h"
#include "enfilade/scan/regions.h"
#include "enfilade/service/collecting/kinds/targets.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/pose_trace.h"
#include "tests/support/collecting.h"

namespace enfilade::service {
namespace EN_UNIT {

using nlohmann::json;
using testing::collection_body;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::row_steps;
using testing::Worker;

constexpr const char* kText = "Water the plant beside the window of the hall.";

/// v2 and v3 see plant 7 ahead of heading 0, v3 a lamp to the right; all are synthetic.
constexpr const char* kBoxes = R"({
  "row_v2": {"7": {"name": "plant#pot", "visible_pos": [12], "bbox2d": [[300, 220, 40, 40]]}},
  "row_v3": {"7": {"name": "plant#pot", "visible_pos": [12, 13], "bbox2d": [[220, 140, 200, 200],
                                                                            [0, 140, 20, 200]]},
             "9": {"name": "lamp", "visible_pos": [15], "bbox2d": [[300, 220, 40, 40]]}}})";

class Kinds : public testing::Collecting {
 protected:
  Kinds() {
    make_folder(served_.root() / "data/reverie");
    write_file_atomically(served_.root() / "data/reverie/BBoxes.json", kBoxes);
  }
  std::string file(const std::string& query) {
    const auto result = served_.get("/api/v1/collections/" + query, organiser_);
    return result ? result->body : "";
  }
  /// What a new collection's faults are.
  std::string faults_of(const json& body) { return create(body).dump(); }
  json accept(std::int64_t task) {
    return put("/api/v1/tasks/" + std::to_string(task) + "/review", reviewer_,
               {{"verdict", "accepted"}});
  }
  json work(std::int64_t task) {
    return served_.json("/api/v1/tasks/" + std::to_string(task), reviewer_);
  }
};

std::string submission(const json& task) {
  return "/api/v1/tasks/" + std::to_string(task.at("task").get<std::int64_t>()) + "/submission";
}
std::string dialogue(const json& task) {
  return "/api/v1/tasks/" + std::to_string(task.at("task").get<std::int64_t>()) + "/dialogue";
}

TEST(Outlines, AreWhereTheirViewsLook) {
  using collecting::kinds::contains;
  const collecting::kinds::Outline ahead = collecting::kinds::outline_of(12, {220, 140, 200, 200});
  EXPECT_TRUE(contains(ahead, {Radians(0), Radians(0)}));
  EXPECT_TRUE(contains(ahead, {Radians(2 * std::numbers::pi - 0.1), Radians(0.1)}));
  EXPECT_FALSE(contains(ahead, {Radians(0.3), Radians(0)}));
  EXPECT_FALSE(contains(ahead, {Radians(0), Radians(-0.3)}));
  EXPECT_FALSE(contains(ahead, {Radians(std::numbers::pi), Radians(0)}));
  EXPECT_NEAR(ahead[1].heading.value, std::atan(100 / (240 / std::tan(std::numbers::pi / 6))),
              1e-9);
  EXPECT_NEAR(ahead[0].elevation.value, -ahead[3].elevation.value, 1e-12);
  // Up to the left: 12 views a row, 30 degrees each.
  const collecting::kinds::Outline up = collecting::kinds::outline_of(24 + 9, {310, 230, 20, 20});
  EXPECT_TRUE(contains(up, {Radians(1.5 * std::numbers::pi), Radians(std::numbers::pi / 6)}));
  EXPECT_FALSE(contains(up, {Radians(1.5 * std::numbers::pi), Radians(0)}));
  const collecting::kinds::Outlines outlines{{"v", {ahead}}};
  EXPECT_NEAR(collecting::kinds::parse_outlines(collecting::kinds::outlines_json(outlines))
                  .at("v")
                  .at(0)[2]
                  .elevation.value,
              ahead[2].elevation.value, 1e-5);
}

TEST_F(Kinds, AnObjectIsDescribedFoundByAnotherAndExportedAsReverie) {
  create(collection_body("pilot", "describe"));
  Worker writer = worker("a");
  const json task = writer.begin();
  EXPECT_EQ(task.at("kind"), "describe");
  EXPECT_EQ(task.at("path"), json({"v0", "v1", "v2", "v3"}));
  EXPECT_EQ(task.at("object").at("name"), "plant");
  EXPECT_EQ(task.at("object").at("outlines").at("v3").size(), 2U);
  EXPECT_EQ(task.at("object").at("outlines").at("v3").at(0).size(), 4U);
  const auto described = task.at("task").get<std::int64_t>();
  EXPECT_EQ(writer.write(described, kText).at("status"), 200);
  EXPECT_EQ(accept(described).at("status"), 200);
  const std::string text = file("pilot/export?split=val_seen");
  const auto read = tasks::parse_annotations(text, "r.json", "val_seen", tasks::Task::kReverie);
  ASSERT_EQ(read.paths.size(), 1U) << text;
  EXPECT_EQ(read.paths[0].id, "1_7");
  EXPECT_THAT(read.paths[0].instructions, ElementsAre(kText));

  json body = collection_body("finding", "find");
  body["sources"] = json::array({{{"collection", "pilot"}}});
  body["per_item"] = 2;
  EXPECT_EQ(create(body).at("status"), 201);
  for (const bool right : {true, false}) {
    Worker finder = worker(right ? "b" : "c", "finding");
    const json found = finder.begin();
    EXPECT_EQ(found.at("instruction"), kText);
    EXPECT_EQ(found.at("start"), "v0");
    EXPECT_FALSE(found.contains("object"));
    EXPECT_FALSE(found.contains("path"));
    const double heading = right ? 0.05 : std::numbers::pi / 2;
    const json after = finder.put(
        submission(found),
        {{"steps", row_steps(0, 3)}, {"point", {{"heading", heading}, {"elevation", 0.0}}}});
    EXPECT_EQ(after.at("status"), 200) << after;
    const json seen = work(found.at("task").get<std::int64_t>());
    EXPECT_EQ(seen.at("bonus"), right);
    EXPECT_EQ(seen.at("pointed_at"), right ? 7 : 9);
  }
  EXPECT_EQ(work(described).at("verified"), json({{"walked", 2}, {"found", 1}}));
  const json results = json::parse(file("finding/export?split=val_seen&what=results"));
  ASSERT_EQ(results.size(), 1U);
  EXPECT_EQ(results[0].at("instr_id"), "1_7_0");
  EXPECT_EQ(results[0].at("predObjId"), 7);
  EXPECT_EQ(results[0].at("trajectory").size(), 4U);
  EXPECT_EQ(tasks::parse_annotations(file("finding/export?split=val_seen"), "r", "s",
                                     tasks::Task::kReverie)
                .paths,
            read.paths);
}

/// As boxes of real homes are: frames and walls are the largest things in view.
constexpr const char* kRealBoxes = R"({
  "row_v2": {"31": {"name": "chair", "visible_pos": [12], "bbox2d": [[0, 0, 90, 90]]}},
  "row_v3": {"1": {"name": "door frame", "visible_pos": [12], "bbox2d": [[100, 0, 300, 480]]},
             "2": {"name": "wall /otherroom", "visible_pos": [13], "bbox2d": [[0, 0, 640, 480]]},
             "3": {"name": "window", "visible_pos": [14], "bbox2d": [[0, 0, 400, 300]]},
             "30": {"name": "chair", "visible_pos": [15], "bbox2d": [[0, 0, 250, 250]]},
             "40": {"name": "picture", "visible_pos": [16], "bbox2d": [[0, 0, 220, 220]]},
             "41": {"name": "picture#small", "visible_pos": [16], "bbox2d": [[300, 0, 20, 20]]},
             "50": {"name": "chest of drawers", "visible_pos": [17], "bbox2d": [[0, 0, 99, 99]]},
             "60": {"name": "toilet", "visible_pos": [18], "bbox2d": [[0, 0, 98, 98]]},
             "70": {"name": "rug", "visible_pos": [], "bbox2d": []}}})";

TEST_F(Kinds, ObjectsAreThingsThatAPersonWouldAskFor) {
  const auto graphs = graph::GraphSet::open(served_.root() / "data/connectivity");
  const auto boxes = tasks::ObjectBoxes::parse(kRealBoxes, "BBoxes.json");
  const auto rooms = scan::RegionMap::parse(R"({"row": {"0": ["v2", "v3"], "1": ["v0"]}})", "r");
  const tasks::PathAnnotation path = testing::row_annotations("val_seen", true).paths[0];
  const auto names = [&](const scan::RegionMap* known_rooms, std::size_t most) {
    collecting::kinds::KnownObjects known(&boxes, *graphs, known_rooms);
    std::vector<std::string> found;
    for (const auto& target : known.targets_of(path, most)) found.push_back(target.name);
    return found;
  };
  // By the largest first; never a frame, and neither of two pictures.
  EXPECT_THAT(names(nullptr, 20), ElementsAre("chair", "chest of drawers", "toilet"));
  EXPECT_THAT(names(nullptr, 1), ElementsAre("chair"));
  // Another viewpoint of the room sees another chair.
  EXPECT_THAT(names(&rooms, 20), ElementsAre("chest of drawers", "toilet"));
}

TEST_F(Kinds, PathsThatEndAtFramesAloneMakeNoTasks) {
  write_file_atomically(served_.root() / "data/reverie/BBoxes.json", R"({
    "row_v3": {"1": {"name": "door frame", "visible_pos": [12], "bbox2d": [[0, 0, 300, 480]]}}})");
  for (const char* kind : {"describe", "dialogue"}) {
    EXPECT_THAT(faults_of(collection_body("pilot", kind)), HasSubstr("that people would ask for"));
  }
}

TEST_F(Kinds, APreviewNamesTheObjectsAndMakesNothing) {
  write_file_atomically(served_.root() / "data/reverie/BBoxes.json", kRealBoxes);
  json body = collection_body("pilot", "describe");
  body["sources"][0]["objects"] = 5;
  const auto preview = [&] {
    return testing::read_answer(served_.client().Post("/api/v1/collections/preview", organiser_,
                                                      body.dump(), "application/json"));
  };
  const json seen = preview();
  EXPECT_EQ(seen.at("status"), 200) << seen;
  EXPECT_EQ(seen.at("items"), 3);
  EXPECT_EQ(seen.at("paths"), 1);
  EXPECT_EQ(seen.at("objects"), json::parse(R"([{"name": "chair", "items": 1},
      {"name": "chest of drawers", "items": 1}, {"name": "toilet", "items": 1}])"));
  EXPECT_EQ(seen.at("collection").at("title"), body.at("title"));
  EXPECT_FALSE(seen.at("collection").contains("link"));
  EXPECT_EQ(seen.at("example").at("object").at("name"), "chair");
  EXPECT_EQ(served_.get("/api/v1/collections/pilot", organiser_)->status, 404);
  EXPECT_EQ(create(body).at("status"), 201);
  EXPECT_EQ(served_.json("/api/v1/collections/pilot/example", reviewer_).at("example"),
            seen.at("example"));
  body["consent"] = "";
  EXPECT_EQ(preview().at("status"), 422);
  EXPECT_EQ(served_.client()
                .Post("/api/v1/collections/preview", reviewer_, body.dump(), "application/json")
                ->status,
            403);
}

TEST_F(Kinds, APreviewOfWalksTellsNoGoal) {
  create(collection_body("pilot", "walk"));
  const json example = served_.json("/api/v1/collections/pilot/example", reviewer_).at("example");
  EXPECT_EQ(example.at("start"), "v0");
  EXPECT_FALSE(example.contains("path"));
  EXPECT_EQ(served_.get("/api/v1/collections/pilot/example")->status, 401);
}

TEST_F(Kinds, TellWhatTheyCannotBeMadeOf) {
  json body = collection_body("pilot", "find");
  EXPECT_THAT(faults_of(body), HasSubstr("names no object"));
  body["sources"] = json::array({{{"collection", "nobody"}}});
  EXPECT_THAT(faults_of(body), HasSubstr("is no collection of descriptions"));
  body = collection_body("pilot", "dialogue");
  body["per_item"] = 3;
  EXPECT_THAT(faults_of(body), HasSubstr("two workers have each dialogue"));
  body["per_item"] = 2;
  body["sources"][0]["practice"] = true;
  EXPECT_THAT(faults_of(body), HasSubstr("no-practice"));
  body = collection_body("pilot", "guide");
  body["language"] = "tlh";
  EXPECT_THAT(faults_of(body), HasSubstr("$.language"));
  body = collection_body("pilot", "describe");
  body["sources"] = json::parse(R"([{"split": "train", "paths": [{"id": "4_8", "path_id": 4,
      "objId": 8, "scan": "row", "heading": 0, "path": ["v0", "v1"], "instructions": []}]}])");
  EXPECT_THAT(faults_of(body), HasSubstr("no viewpoint sees its goal"));
  body["kind"] = "sing";
  EXPECT_THAT(faults_of(body), HasSubstr("write or walk or describe or find or guide or dialogue"));
}

json guide_body(const std::string& instruction, int last) {
  json words = json::array();
  double second = 0;
  std::istringstream in(instruction);
  for (std::string word; in >> word; second += 0.5) {
    words.push_back({{"word", word}, {"start", second}, {"end", second + 0.4}});
  }
  return {{"instruction", instruction}, {"words", words}, {"steps", row_steps(0, last)}};
}

TEST_F(Kinds, ABrokenFileOfBoxesIsReadOnce) {
  const auto file = served_.root() / "data/reverie/BBoxes.json";
  write_file_atomically(file, "{\"row_v2\": 7}");
  const std::string first = faults_of(collection_body("pilot", "describe"));
  EXPECT_THAT(first, HasSubstr("$.row_v2"));
  write_file_atomically(file, kBoxes);
  EXPECT_EQ(faults_of(collection_body("pilot", "describe")), first) << "as until the next start";
}

TEST_F(Kinds, AGuideKeepsWordsAndPosesWithTheirTimes) {
  json body = collection_body("pilot", "guide");
  body["language"] = "hi-IN";
  create(body);
  Worker guide = worker("a");
  const json task = guide.begin();
  EXPECT_EQ(task.at("path").size(), 4U);
  const std::string target = submission(task);
  json wrong = guide_body(kText, 2);
  EXPECT_THAT(guide.put(target, wrong).dump(), HasSubstr("not walked to its end"));
  wrong = guide_body(kText, 4);
  EXPECT_THAT(guide.put(target, wrong).dump(), HasSubstr("is not on the path"));
  wrong = guide_body(kText, 3);
  wrong["words"][1]["word"] = "a";
  EXPECT_THAT(guide.put(target, wrong).dump(), HasSubstr("$.words[1].word"));
  wrong = guide_body(kText, 3);
  wrong["words"][2]["start"] = 0;
  EXPECT_THAT(guide.put(target, wrong).dump(), HasSubstr("time-runs-back"));
  wrong["words"].erase(0);
  EXPECT_THAT(guide.put(target, wrong).dump(), HasSubstr("8 words, and the instruction has 9"));
  EXPECT_EQ(guide.put(target, guide_body(kText, 3)).at("status"), 200);
  const auto number = task.at("task").get<std::int64_t>();
  EXPECT_EQ(work(number).at("words").size(), 9U);
  EXPECT_EQ(accept(number).at("status"), 200);
  EXPECT_EQ(put("/api/v1/tasks/" + std::to_string(number) + "/instruction", reviewer_,
                {{"instruction", kText}})
                .at("status"),
            409);
  const auto read = tasks::parse_annotations(file("pilot/export?split=val_seen"), "g", "val_seen",
                                             tasks::Task::kRxr);
  ASSERT_EQ(read.paths.size(), 1U);
  EXPECT_EQ(read.paths[0].details[0].language, "hi-IN");
  EXPECT_EQ(read.paths[0].details[0].id, "1_" + std::to_string(number));
  EXPECT_EQ(read.paths[0].details[0].words.at(1).start, 0.5);
  const json traces = json::parse(file("pilot/export?split=val_seen&what=walks"));
  EXPECT_EQ(traces.at(0).at("instr_id"), "1_" + std::to_string(number));
  EXPECT_EQ(traces.at(0).at("steps").size(), 4U);
  const auto zip =
      scan::FileTree::zip_in_memory(file("pilot/export?split=val_seen&what=traces"), "traces.zip");
  ASSERT_EQ(zip->names().size(), 1U);
  const std::string name = tasks::pose_trace_name(tasks::TraceRole::kGuide, number);
  const tasks::PoseTrace trace = tasks::parse_pose_trace(zip->read(name).value(), name);
  ASSERT_EQ(trace.snapshots.size(), 4U);
  EXPECT_EQ(trace.snapshots[3].viewpoint, "v3");
  const json& last = traces.at(0).at("steps").at(3);
  EXPECT_NEAR(trace.snapshots[3].time, last.at("seconds").get<double>(), 1e-6);
  const tasks::CameraLook look = look_of(trace.snapshots[3]);
  EXPECT_NEAR(look.heading.value, last.at("heading").get<double>(), 1e-6);
  EXPECT_NEAR(look.view_angle.value, std::numbers::pi / 3, 1e-6);
}

json post(testing::Served& served, const Worker& who, const std::string& target, const json& body) {
  return testing::read_answer(
      served.client().Post(target, who.headers(), body.dump(), "application/json"));
}

TEST_F(Kinds, TwoPeopleTalkAndItIsADialogueOfCvdn) {
  create(collection_body("pilot", "dialogue"));
  Worker navigator = worker("a"), oracle = worker("b"), late = worker("c");
  const json walks = navigator.begin(), answers = oracle.begin();
  EXPECT_EQ(walks.at("role"), "navigator");
  EXPECT_EQ(walks.at("target"), "plant");
  EXPECT_FALSE(walks.contains("object"));
  EXPECT_EQ(answers.at("role"), "oracle");
  EXPECT_TRUE(answers.at("object").at("outlines").contains("v3"));
  EXPECT_TRUE(late.begin().is_null());

  const auto act = [&](Worker& who, const json& task, const json& body) {
    return post(served_, who, dialogue(task), body);
  };
  const json step = {{"viewpoint", "v1"}, {"heading", 1.5}, {"elevation", 0.0}};
  EXPECT_THAT(act(oracle, answers, {{"say", "Hello?"}}).dump(), HasSubstr("the other one's turn"));
  EXPECT_EQ(act(navigator, walks, {{"steps", json::array({step})}}).at("status"), 200);
  json far = step;
  far["viewpoint"] = "v4";
  EXPECT_THAT(act(navigator, walks, {{"steps", json::array({far})}}).dump(),
              HasSubstr("no edge leads from"));
  EXPECT_EQ(act(navigator, walks, {{"say", "Left or right?"}}).at("turn"), "oracle");
  EXPECT_EQ(act(navigator, walks, {{"stop", true}}).at("status"), 409);
  const json seen = served_.json(dialogue(answers) + "?after=1", oracle.headers());
  EXPECT_EQ(seen.at("partner"), true);
  EXPECT_EQ(seen.at("here").at("viewpoint"), "v1");
  EXPECT_EQ(seen.at("ahead"), json({"v1", "v2"}));  // from v2 on the plant is seen
  EXPECT_EQ(seen.at("turns").size(), 1U);
  EXPECT_EQ(act(oracle, answers, {{"stop", true}}).at("status"), 422);
  EXPECT_EQ(act(oracle, answers, {{"say", "Straight on."}}).at("turn"), "navigator");
  json on = step;
  on["viewpoint"] = "v2";
  EXPECT_EQ(act(navigator, walks, {{"steps", json::array({on})}}).at("status"), 200);
  EXPECT_EQ(act(navigator, walks, {{"stop", true}}).at("finished"), true);
  EXPECT_EQ(act(navigator, walks, {{"stop", true}}).at("error").at("code"), "already-submitted");
  EXPECT_EQ(oracle.visit().at("done"), 1);
  EXPECT_EQ(navigator.visit().at("done"), 1);
  EXPECT_EQ(progress().at("complete"), 1);
  const json reviewed = work(walks.at("task").get<std::int64_t>());
  EXPECT_EQ(reviewed.at("bonus"), true);
  EXPECT_EQ(reviewed.at("turns").size(), 5U);

  const std::string text = file("pilot/export?split=val_seen");
  const auto read = tasks::parse_annotations(text, "c.json", "val_seen", tasks::Task::kCvdn);
  ASSERT_EQ(read.paths.size(), 2U) << text;
  EXPECT_THAT(read.paths[0].path,
              ElementsAre("v0", "v1", "v2"));  // the oracle's, as v2 was reached
  EXPECT_THAT(read.paths[1].path, ElementsAre("v1", "v2"));
  EXPECT_EQ(read.paths[1].instructions[0], "<NAV> Left or right? <ORA> Straight on. <TAR> plant");
  EXPECT_EQ(read.paths[0].group, read.paths[1].group);
  const json whole = json::parse(file("pilot/export?split=val_seen&what=dialogues"));
  EXPECT_EQ(whole.at(0).at("turns").size(), 5U);
  EXPECT_EQ(whole.at(0).at("workers").size(), 2U);
}

TEST_F(Kinds, WhoeverLeavesADialogueLeavesTheSeatToAnother) {
  json body = collection_body("pilot", "dialogue");
  body["lease_minutes"] = 10;
  create(body);
  Worker navigator = worker("a"), leaves = worker("b"), comes = worker("c");
  const json walks = navigator.begin(), answers = leaves.begin();
  post(served_, navigator, dialogue(walks), {{"say", "Which way?"}});
  now_ += 6 * 60;
  // Whoever waits keeps the task by asking.
  EXPECT_EQ(served_.json(dialogue(walks), navigator.headers()).at("partner"), true);
  now_ += 6 * 60;
  EXPECT_EQ(served_.json(dialogue(walks), navigator.headers()).at("partner"), false);
  const json taken = comes.begin();
  EXPECT_EQ(taken.at("role"), "oracle");
  EXPECT_EQ(served_.json(dialogue(taken), comes.headers()).at("turns").size(), 1U);
  EXPECT_EQ(served_.json(dialogue(answers), leaves.headers()).at("error").at("code"),
            "lease-expired");
  EXPECT_EQ(post(served_, comes, dialogue(taken), {{"say", "To the window."}}).at("status"), 200);
  EXPECT_EQ(post(served_, navigator, dialogue(walks), {{"stop", true}}).at("status"), 200);
  EXPECT_EQ(work(walks.at("task").get<std::int64_t>()).at("bonus"), true);  // 2 m from v2
}

TEST_F(Kinds, ARegionOfCvdnIsAGoalToo) {
  json body = collection_body("pilot", "dialogue");
  body["sources"] = json::parse(R"([{"split": "train", "paths": [{"inst_idx": 5, "scan": "row",
      "target": "sofa", "start_pano": {"heading": 1, "pano": "v1"}, "dialog_history": [],
      "end_panos": ["v5"], "player_path": ["v1", "v2"], "planner_path": ["v1", "v2", "v3"]}]}])");
  EXPECT_EQ(create(body).at("status"), 201);
  Worker navigator = worker("a");
  const json task = navigator.begin();
  EXPECT_EQ(task.at("target"), "sofa");
  EXPECT_EQ(task.at("start"), "v1");
}

}  // namespace EN_UNIT
}  // namespace enfilade::service
