// Goals of all benchmarks, looked up in a graph; results in the forms that their code writes; and
// their scores.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"
#include "tests/support/graphs.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::ThrowsMessage;

// The square v0 v1 v2 v3 of 2 m, and v4, which is left out.
std::shared_ptr<const graph::GraphSet> graphs() {
  scan::Connectivity square = graph::testing::connectivity(
      "square", {{0, 0, 1.5}, {2, 0, 1.5}, {2, 2, 1.5}, {0, 2, 1.5}, {9, 9, 1.5}},
      {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {3, 4}});
  square.entries[4].included = false;
  std::vector<graph::NavGraph> list;
  list.emplace_back(square);
  return graph::GraphSet::of(std::move(list));
}

PathAnnotation entry(std::vector<std::string> path, NamedGoal goal = NearEnd()) {
  PathAnnotation one;
  one.path_id = 7;
  one.scan = "square";
  one.path = std::move(path);
  one.instructions = {"Go.", "Walk.", "Move.", "Step."};
  one.goal = std::move(goal);
  return one;
}

Annotations of(Task task, PathAnnotation path) {
  Annotations annotations{"val", "val.json", {}, task};
  annotations.paths.push_back(std::move(path));
  return annotations;
}

ViewedObject seen(std::int64_t id, bool visible) {
  ViewedObject object;
  object.id = id;
  object.name = "chair";
  if (visible) {
    object.views = {3};
    object.boxes = {{10, 20, 30, 40}};
  }
  return object;
}

// Object 5 is seen from v2, v3 and the viewpoint that is left out; from v1 it has no view.
ObjectBoxes objects() {
  ObjectBoxes boxes;
  boxes.add("square", "v1", {seen(5, false)});
  boxes.add("square", "v2", {seen(5, true), seen(6, true)});
  boxes.add("square", "v3", {seen(5, true)});
  boxes.add("square", "v4", {seen(5, true)});
  return boxes;
}

EpisodeSet reverie() {
  PathAnnotation path = entry({"v0", "v1", "v2"}, NamedObject{5});
  path.id = "7_5";
  const ObjectBoxes boxes = objects();
  return make_episodes(of(Task::kReverie, path), graphs(), Instructions::kScored, &boxes);
}

TEST(Episodes, OnlyR2rHasInstructionsThatAreNotScored) {
  EXPECT_EQ(make_episodes(of(Task::kR2r, entry({"v0", "v1"})), graphs()).episodes.size(), 3U);
  EXPECT_EQ(make_episodes(of(Task::kR4r, entry({"v0", "v1"})), graphs()).episodes.size(), 4U);
}

TEST(Episodes, AnObjectIsSeenFromWhereOneCanStandAndItHasAView) {
  const EpisodeSet set = reverie();
  const auto& goal = std::get<SeenObject>(set.paths[0].goal);
  EXPECT_EQ(goal.id, 5);
  EXPECT_THAT(goal.seen_from, ElementsAre(ViewpointIndex(2), ViewpointIndex(3)));
  EXPECT_EQ(set.episodes[3].instruction_id, "7_5_3");
  EXPECT_FALSE(goals_hidden(set));
}

TEST(Episodes, AnObjectThatNobodySeesIsAFault) {
  const ObjectBoxes boxes = objects();
  const auto look_up = [](std::int64_t id, const ObjectBoxes* known) {
    return make_episodes(of(Task::kReverie, entry({"v0", "v1"}, NamedObject{id})), graphs(),
                         Instructions::kScored, known);
  };
  EXPECT_THAT([&] { look_up(99999, &boxes); },
              ThrowsMessage<InvalidInput>(HasSubstr("$[0].objId: no viewpoint of scan square")));
  EXPECT_THAT(std::get<SeenObject>(look_up(99999, nullptr).paths[0].goal).seen_from, IsEmpty())
      << "without boxes nothing is known";
}

TEST(Episodes, GoalsAreLookedUpAndFaultsHaveTheirPlaces) {
  const auto fault = [](Task task, const PathAnnotation& path) {
    return [task, path] { make_episodes(of(task, path), graphs()); };
  };
  EXPECT_THAT(fault(Task::kR2rBack, entry({"v0", "v1"}, NamedTurningPoint{"v9"})),
              ThrowsMessage<InvalidInput>(HasSubstr("$[0].midstop")));
  EXPECT_THAT(fault(Task::kCvdn, entry({"v0"}, NamedRegion{"plant", {"v1", "v4"}, {}, {}})),
              ThrowsMessage<InvalidInput>(HasSubstr("$[0].end_panos[1]")));
  EXPECT_THAT(fault(Task::kCvdn, entry({"v0"}, NamedRegion{"plant", {"v1"}, {"v0", "x"}, {}})),
              ThrowsMessage<InvalidInput>(HasSubstr("$[0].player_path[1]")));
  NamedBoxes boxes;
  boxes.boxes.push_back({"v8", "vase", {}, {}});
  EXPECT_THAT(fault(Task::kSoon, entry({"v0"}, boxes)),
              ThrowsMessage<InvalidInput>(HasSubstr("$[0].bboxes[0].image_id")));
  EXPECT_THAT(fault(Task::kR4r, entry({"v0", "v2"})),
              ThrowsMessage<InvalidInput>(HasSubstr("no edge leads")));
}

TEST(Episodes, BoxesKeepTheNameOfTheirObject) {
  NamedBoxes boxes;
  boxes.boxes.push_back({"v1", "vase", {}, {}});
  boxes.boxes.push_back({"v2", "", {}, {}});
  const EpisodeSet set = make_episodes(of(Task::kSoon, entry({"v0", "v1"}, boxes)), graphs());
  const auto& found = std::get<Boxes>(set.paths.at(0).goal).boxes;
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].object, "vase");
  EXPECT_EQ(found[1].object, "");
}

TEST(Episodes, AGoalIsHiddenWhereTheFileHasNone) {
  EXPECT_TRUE(goals_hidden(make_episodes(of(Task::kRxr, entry({"v0"})), graphs())));
  EXPECT_TRUE(goals_hidden(make_episodes(of(Task::kSoon, entry({"v0"}, HiddenGoal())), graphs())));
  const auto region = entry({"v0"}, NamedRegion{"plant", {"v1"}, {"v0"}, {"v0", "v1"}});
  EXPECT_FALSE(goals_hidden(make_episodes(of(Task::kCvdn, region), graphs())));
}

TEST(Episodes, PathsThatBelongTogetherAreAGroup) {
  Annotations annotations = of(Task::kRxr, entry({"v0", "v1"}));
  for (const std::int64_t group : {11, 12, 11}) {
    PathAnnotation path = entry({"v0", "v1"});
    path.path_id = static_cast<std::int64_t>(annotations.paths.size() + 20);
    path.group = group;
    annotations.paths.push_back(path);
  }
  const EpisodeSet set = make_episodes(annotations, graphs());
  std::vector<std::size_t> groups;
  for (const ReferencePath& path : set.paths) groups.push_back(path.group);
  EXPECT_THAT(groups, ElementsAre(0, 1, 2, 1));
}

std::string results_of(const std::string& fields) {
  std::string text = "[";
  for (int k = 0; k < 4; ++k) {
    text += std::string(k == 0 ? "" : ", ") + "{\"instr_id\": \"7_5_" + std::to_string(k) + "\", " +
            fields + "}";
  }
  return text + "]";
}

TEST(TaskResults, OfReverieNameTheirObjectInEitherKey) {
  const EpisodeSet set = reverie();
  const std::string walk = R"("trajectory": [["v0"], ["v1", "v2"]])";
  for (const char* field : {R"("predObjId": 5)", R"("pred_objid": "5")", R"("predObjId": "5")"}) {
    const Results results = parse_results(results_of(walk + ", " + field), "r.json", set);
    EXPECT_EQ(results.trajectories[1].object, "5") << field;
    EXPECT_EQ(results.trajectories[1].points.size(), 3U);
    EXPECT_EQ(results.trajectories[1].actions, 1U) << "a group is an action";
  }
  EXPECT_EQ(parse_results(results_of(walk + R"(, "predObjId": null)"), "r.json", set)
                .trajectories[0]
                .object,
            "");
  for (const auto& [field, message] : std::vector<std::pair<const char*, const char*>>{
           {"\"x\": 0", "neither predObjId nor pred_objid"},
           {"\"predObjId\": 5.5", "$[0].predObjId"},
           {"\"predObjId\": [5]", "$[0].predObjId"}}) {
    const std::string text = results_of(walk + ", " + field);
    EXPECT_THAT([&] { parse_results(text, "r.json", set); },
                ThrowsMessage<InvalidInput>(HasSubstr(message)));
  }
}

TEST(TaskResults, OfCvdnAndRxrGoByNumbersOrTexts) {
  PathAnnotation dialogue = entry({"v0"}, NamedRegion{"plant", {"v2"}, {"v0"}, {"v0", "v1"}});
  dialogue.instructions = {"<TAR> plant"};
  dialogue.details.resize(1);
  dialogue.details[0].id = "1000";
  const EpisodeSet cvdn = make_episodes(of(Task::kCvdn, dialogue), graphs());
  for (const char* id : {R"("inst_idx": 1000)", R"("instr_id": "1000")"}) {
    const std::string text = std::string("[{") + id + R"(, "trajectory": [["v0", 0, 0]]}])";
    EXPECT_EQ(parse_results(text, "r.json", cvdn).trajectories[0].points.size(), 1U) << id;
  }
  EXPECT_THAT([&] { parse_results(R"([{"trajectory": ["v0"]}])", "r.json", cvdn); },
              ThrowsMessage<InvalidInput>(HasSubstr("neither instr_id nor inst_idx")));
  EXPECT_THAT(
      [&] { parse_results(R"([{"inst_idx": "1000", "trajectory": ["v0"]}])", "r.json", cvdn); },
      ThrowsMessage<InvalidInput>(HasSubstr("not a whole number")));

  PathAnnotation spoken = entry({"v0", "v1"});
  spoken.instructions = {"Okay."};
  spoken.details.resize(1);
  spoken.details[0].id = "11_26";
  const EpisodeSet rxr = make_episodes(of(Task::kRxr, spoken), graphs());
  for (const char* text :
       {R"([{"instruction_id": 26, "path": ["v0", "v1"]}])",
        R"([{"instr_id": "11_26", "trajectory": [["v0", 0, 0], ["v1", 0, 0]]}])"}) {
    EXPECT_EQ(parse_results(text, "r.json", rxr).trajectories[0].points.size(), 2U) << text;
  }
  EXPECT_THAT([&] { parse_results(R"([{"instruction_id": 26}])", "r.json", rxr); },
              ThrowsMessage<InvalidInput>(HasSubstr("neither trajectory nor path")));
}

TEST(TaskResults, OfSoonPoint) {
  NamedBoxes boxes;
  boxes.boxes.push_back({"v1", "vase", {}, {}});
  PathAnnotation path = entry({"v0", "v1"}, boxes);
  path.id = "3-0";
  path.instructions = {"The vase."};
  const EpisodeSet set = make_episodes(of(Task::kSoon, path), graphs());
  const auto read = [&set](const std::string& pointed) {
    return parse_results(R"([{"instr_id": "3-0_0", "trajectory": {"path": [["v0"], ["v1"]], )" +
                             pointed + "}}]",
                         "r.json", set)
        .trajectories[0];
  };
  EXPECT_EQ(read(R"("obj_heading": [0.25], "obj_elevation": [0.5])").point,
            (SpherePoint{0.25, 0.5}));
  EXPECT_EQ(read(R"("obj_heading": null, "obj_elevation": null)").point, std::nullopt);
  EXPECT_THAT([&] { read(R"("obj_heading": 0.25, "obj_elevation": [0.5])"); },
              ThrowsMessage<InvalidInput>(HasSubstr("$[0].trajectory.obj_heading")));
  EXPECT_THAT([&] { read(R"("obj_heading": [0.25, 1], "obj_elevation": [0.5])"); },
              ThrowsMessage<InvalidInput>(HasSubstr("a list of one number")));
  EXPECT_THAT([&] { read(R"("obj_heading": [0.25])"); },
              ThrowsMessage<InvalidInput>(HasSubstr("obj_elevation")));
}

TEST(TaskScores, HaveMeansIntervalsAndEachEpisode) {
  const EpisodeSet set = reverie();
  const Results results = parse_results(
      results_of(R"("trajectory": ["v0", "v1", "v2"], "predObjId": 5)"), "r.json", set);
  const ScoreTable score =
      compute_score(results.trajectories, set, benchmark(Task::kReverie).scorer("official"));
  EXPECT_EQ(score.episodes, 4U);
  EXPECT_EQ(score.means[1].mean, 1) << "success_rate";
  EXPECT_EQ(score.means[1].low, 1);
  EXPECT_TRUE(std::isnan(score.means[6].mean)) << "shortest, of which it prints no mean";
  EXPECT_THAT(to_table(score), HasSubstr("rgspl"));
  const std::string json = to_json(score, true);
  EXPECT_THAT(json, HasSubstr("\"7_5_2\""));
  EXPECT_THAT(json, HasSubstr("\"task\": \"reverie\""));
  EXPECT_THAT(
      [&] { compute_score(results.trajectories, set, benchmark(Task::kRxr).scorer("hamt")); },
      ThrowsMessage<ArgumentError>(HasSubstr("is of RxR, the episodes are of REVERIE")));
  EXPECT_THROW(compute_score({}, set, *score.scorer), ArgumentError);
}

TEST(TaskFiles, AreToldApartByTheirFirstRecord) {
  const auto task = [](const char* text) { return find_task(text); };
  EXPECT_EQ(task(R"([{"path_id": 1, "scan": "a"}])"), Task::kR2r);
  EXPECT_EQ(task(R"([{"id": "1_2", "objId": 2, "scan": "a"}])"), Task::kReverie);
  EXPECT_EQ(task("{\"path_id\": 1, \"language\": \"en-IN\"}\n{\"path_id\": 2}"), Task::kRxr);
  EXPECT_EQ(task(R"([{"inst_idx": 1, "scan": "a"}])"), Task::kCvdn);
  EXPECT_EQ(task(R"([{"path": [["a"]], "bboxes": []}])"), Task::kSoon);
  EXPECT_EQ(task(R"([{"path": [["a"]], "instructions": [["n", "a", "r", "g", "t"]]}])"),
            Task::kSoon)
      << "a test split";
  EXPECT_EQ(task(R"({"path_id": "4-0", "path": ["a"], "instructions": [{"full": "t"}]})"),
            Task::kSoon);
  EXPECT_EQ(task(R"([{"path_id": 1, "midstop": "a"}])"), Task::kR2rBack);
  EXPECT_EQ(task(R"([{"path_id": 1, "first_path_id": 2}])"), Task::kR4r);
  for (const char* none : {"", "[]", "[1]", "[{\"a\": 1}]", "{", "[[[["}) {
    EXPECT_EQ(task(none), std::nullopt) << none;
  }
  EXPECT_EQ(find_task_of_results(R"([{"instr_id": "1", "pred_objid": null}])"), Task::kReverie);
  EXPECT_EQ(find_task_of_results(R"([{"instr_id": "1", "trajectory": {"path": []}}])"),
            Task::kSoon);
  EXPECT_EQ(find_task_of_results(R"([{"instr_id": "1", "trajectory": []}])"), std::nullopt);
}

TEST(TaskFiles, AreWrittenInTheirOwnForm) {
  Annotations annotations = of(Task::kR2rBack, entry({"v0", "v1"}, NamedTurningPoint{"v1"}));
  annotations.paths[0].distance = 2.5;
  const std::string text = to_text(annotations);
  EXPECT_THAT(text, HasSubstr("\"midstop\""));
  EXPECT_EQ(to_text(parse_annotations(text, "a.json", "val", Task::kR2rBack)), text);
  PathAnnotation plant = entry({"v0", "v1"}, NamedObject{7});
  plant.path_id = 3;
  plant.id = "3_7";
  plant.group = 3;
  const Annotations objects = of(Task::kReverie, plant);
  EXPECT_EQ(parse_annotations(to_text(objects), "a.json", "val", Task::kReverie).paths,
            objects.paths);
  EXPECT_THAT([] { to_text(of(Task::kReverie, entry({"v0"}))); },
              ThrowsMessage<ArgumentError>(HasSubstr("neither hidden nor an object")));
  const Demonstration walk{1, 2, 3, {"v0"}, 0, 1, 1, 0, 1, 1};
  EXPECT_THAT(to_text(std::span(&walk, 1)), HasSubstr("\"demonstration_id\":1"));
  EXPECT_THAT([] { to_released_soon(of(Task::kSoon, entry({"v0"}))); },
              ThrowsMessage<ArgumentError>(HasSubstr("no SOON path's")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
