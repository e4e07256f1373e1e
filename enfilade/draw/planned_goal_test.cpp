#include "enfilade/draw/planned_goal.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "enfilade/core/errors.h"
#include "enfilade/draw/contact_sheet.h"
#include "enfilade/draw/floor_plan.h"
#include "enfilade/tasks/objects.h"
#include "tests/support/graphs.h"

namespace enfilade::draw {
namespace EN_UNIT {
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::ThrowsMessage;

constexpr ViewpointIndex kStart(0), kMiddle(1), kEnd(2), kAside(3);

tasks::ReferencePath path_to(tasks::Goal goal) {
  tasks::ReferencePath path;
  path.viewpoints = {kStart, kMiddle, kEnd};
  path.goal = std::move(goal);
  return path;
}

tasks::ObjectBoxes plant_at(const std::string& scan, const std::string& viewpoint) {
  tasks::ViewedObject object;
  object.id = 57;
  object.name = "plant#pot";
  object.views = {15};
  object.boxes = {{250, 200, 140, 100}};
  tasks::ObjectBoxes objects;
  objects.add(scan, viewpoint, {object});
  return objects;
}

std::string plan_of(const tasks::ReferencePath& path, std::string_view what = {}) {
  const graph::NavGraph graph(graph::testing::square());
  FloorPlanOptions options;
  options.goal = planned_goal(path, what);
  return floor_plan_svg(graph, {{PathRole::kReference, path.viewpoints, ""}}, options);
}

constexpr const char* kCircle = "stroke-dasharray=\"3 4\"";
constexpr const char* kSquare = "width=\"13\" height=\"13\"";
constexpr const char* kDiamond = "l9,9l-9,9l-9,-9Z";

TEST(PlannedGoal, OfThePathsEndIsTheCircleAsBefore) {
  EXPECT_FALSE(planned_goal(path_to(tasks::NearEnd())));
  EXPECT_FALSE(planned_goal(path_to(tasks::HiddenGoal())));
  const std::string svg = plan_of(path_to(tasks::NearEnd()));
  EXPECT_THAT(svg, HasSubstr(kCircle));
  EXPECT_THAT(svg, HasSubstr("goal, 3 m around it"));
}

TEST(PlannedGoal, MarksWhoSeesTheObject) {
  const auto path = path_to(tasks::SeenObject{57, {kEnd, kAside}});
  const auto goal = planned_goal(path, "plant");
  ASSERT_TRUE(goal);
  EXPECT_THAT(goal->viewpoints, ElementsAre(kEnd, kAside));
  EXPECT_EQ(goal->label, "sees the plant (2 viewpoints)");
  EXPECT_EQ(planned_goal(path)->label, "sees object 57 (2 viewpoints)");
  const std::string svg = plan_of(path, "plant");
  EXPECT_THAT(svg, HasSubstr(kSquare));
  EXPECT_THAT(svg, HasSubstr("sees the plant (2 viewpoints)"));
  EXPECT_THAT(svg, HasSubstr("end of the reference path"));
  EXPECT_THAT(svg, Not(HasSubstr(kCircle))) << "3 m around the end mean nothing";
}

TEST(PlannedGoal, MarksARegionATurningPointAndBoxes) {
  const std::string region = plan_of(path_to(tasks::Region{{kEnd, kAside}, {}, {}}), "chair");
  EXPECT_THAT(region, HasSubstr("region of the chair (2 viewpoints)"));
  EXPECT_THAT(region, HasSubstr("fill-opacity=\"0.55\""));
  EXPECT_THAT(region, Not(HasSubstr(kCircle)));
  const std::string turn = plan_of(path_to(tasks::TurningPoint{kMiddle}));
  EXPECT_THAT(turn, HasSubstr(kDiamond));
  EXPECT_THAT(turn, HasSubstr("turning point"));
  EXPECT_THAT(turn, HasSubstr(kCircle));
  tasks::Box box;
  box.viewpoint = kAside;
  const auto boxes = path_to(tasks::Boxes{{box, box}, {}});
  EXPECT_THAT(planned_goal(boxes)->viewpoints, ElementsAre(kAside));
  EXPECT_THAT(plan_of(boxes), HasSubstr("shows the object (1 viewpoint)"));
}

TEST(PlannedGoal, OutsideOfTheGraphIsRefused) {
  EXPECT_THAT([] { plan_of(path_to(tasks::TurningPoint{ViewpointIndex(9)})); },
              ThrowsMessage<ArgumentError>(HasSubstr("goal.viewpoints[0]: 9, not below 4")));
}

TEST(PlannedGoal, IsNamed) {
  std::vector<graph::NavGraph> list;
  list.emplace_back(graph::testing::square());
  const auto graphs = graph::GraphSet::of(std::move(list));
  const std::string scan(graphs->graph(ScanIndex()).scan());
  const tasks::ObjectBoxes objects = plant_at(scan, "v2");
  tasks::EpisodeSet set;
  set.graphs = graphs;
  set.paths = {path_to(tasks::SeenObject{57, {kEnd}}), path_to(tasks::Region{{kEnd}, {}, {}}),
               path_to(tasks::Boxes{})};
  tasks::Episode soon{"", 2, 0, "", {}};
  soon.details.fields = {{"obj_name", "The lamp. "}};
  EXPECT_EQ(name_of_goal(set, {"", 0, 0, "", {}}, &objects), "plant");
  EXPECT_EQ(name_of_goal(set, {"", 0, 0, "", {}}, nullptr), "");
  EXPECT_EQ(name_of_goal(set, {"", 1, 0, "<NAV> where? <TAR> chair", {}}, nullptr), "chair");
  EXPECT_EQ(name_of_goal(set, soon, nullptr), "lamp");
  // The boxes' own name is no sentence.
  soon.details.fields = {{"obj_name", "Find the orange pair of shoes. "}};
  tasks::Box unnamed, named;
  named.object = "shoes";
  set.paths[2] = path_to(tasks::Boxes{{unnamed, named}, {}});
  EXPECT_EQ(name_of_goal(set, soon, nullptr), "shoes");
}

TEST(PlannedGoal, HasAShotThatLooksAtTheObject) {
  const graph::NavGraph graph(graph::testing::square());
  const tasks::ObjectBoxes objects = plant_at(std::string(graph.scan()), "v3");
  const auto path = path_to(tasks::SeenObject{57, {kAside}});
  const auto shot = shot_of_goal(graph, path, &objects);
  ASSERT_TRUE(shot);
  EXPECT_EQ(shot->viewpoint, "v3");
  EXPECT_NEAR(to_degrees(shot->heading), 90, 0.1) << "view 15 looks east";
  EXPECT_EQ(shot->outlines.size(), 1U);
  EXPECT_FALSE(shot_of_goal(graph, path, nullptr));
  EXPECT_FALSE(shot_of_goal(graph, path_to(tasks::NearEnd()), &objects));
  std::vector<Shot> shots{*shot, *shot};
  shots[0].viewpoint = "v0";
  outline_goal(shots, graph, path.goal, &objects);
  EXPECT_TRUE(shots[0].outlines.empty());
  EXPECT_EQ(shots[1].outlines.size(), 1U);
}

tasks::Episode saying(const std::string& text, tasks::InstructionDetails details = {}) {
  return {"1_0", 0, 0, text, std::move(details)};
}

TEST(EpisodeText, IsTheInstructionInQuotationMarks) {
  EXPECT_THAT(episode_lines(saying(" Walk on.\n")), ElementsAre("\u201cWalk on.\u201d"));
  EXPECT_TRUE(episode_lines(saying(" ")).empty());
  tasks::InstructionDetails details;
  details.language = "hi-IN";
  EXPECT_THAT(episode_lines(saying("Walk on.", details)),
              ElementsAre("Language: hi-IN", "\u201cWalk on.\u201d"));
}

TEST(EpisodeText, HasADialogueAsTurns) {
  tasks::InstructionDetails details;
  details.turns = {{"navigator", "Left or right?", 3}, {"oracle", " Left. ", 3}};
  EXPECT_THAT(episode_lines(saying("<NAV> Left or right? <ORA> Left. <TAR> plant", details)),
              ElementsAre("Navigator, after 3 steps: Left or right?",
                          "Oracle, after 3 steps: Left.", "Looking for: plant"));
  EXPECT_THAT(episode_lines(saying("<TAR> plant")), ElementsAre("Looking for: plant"));
}

TEST(EpisodeText, HasPiecesWithTheirPlacesAndNamedParts) {
  tasks::InstructionDetails details;
  details.parts = {{{"walk", "on"}, std::pair<std::size_t, std::size_t>{0, 1}},
                   {{"stop"}, std::pair<std::size_t, std::size_t>{1, 1}},
                   {{"there"}, std::nullopt}};
  details.fields = {{"region", "in the hall"}, {"relation", ""}};
  EXPECT_THAT(episode_lines(saying("Walk on, stop there.", details)),
              ElementsAre("\u201cWalk on, stop there.\u201d", "1. walk on (viewpoints 1 to 2)",
                          "2. stop (viewpoint 2)", "3. there", "region: in the hall"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw
