#include "enfilade/agents/continuous_environment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "tests/support/made_meshes.h"

namespace enfilade::agents {
namespace EN_UNIT {

using continuous::Action;
using continuous::Building;
using continuous::Buildings;
using continuous::NavigationMesh;
using continuous::SimulatorConfig;

// 5 x 4 m, with a pillar of 1 x 1 m in the middle.
std::shared_ptr<const Buildings> pillar_room() {
  const mesh::RayTracer tracer(std::make_shared<const mesh::Mesh>(
      mesh::testing::Maker().room(0, 0, 5, 4).box({2, 1.5F, 0}, {3, 2.5F, 2.6F}).mesh));
  return std::make_shared<const Buildings>(std::vector<Building>{
      {"room", std::make_shared<const NavigationMesh>(make_floor_polygons(tracer))}});
}

tasks::ContinuousEpisode episode(std::int64_t id, Vec3d start, Vec3d goal) {
  tasks::ContinuousEpisode e;
  e.id = id;
  e.trajectory_id = id;
  e.scene = "made/room/room.glb";
  e.start = start;
  e.rotation = tasks::StartRotation::of(degrees(90));
  e.goals = {{.position = goal, .radius = 3}};
  e.reference_path = {start, {2.5, 0.75, 0}, goal};
  return e;
}

ContinuousWorld world() {
  tasks::ContinuousEpisodes episodes;
  episodes.file = "made.json";
  episodes.episodes = {episode(1, {0.5, 2, 0}, {4.5, 2, 0}), episode(2, {4.5, 3, 0}, {0.5, 1, 0})};
  return {std::make_shared<const tasks::ContinuousEpisodes>(episodes), nullptr, pillar_room()};
}

ContinuousEnvironment environment(std::size_t n, const ContinuousWorld& in = world()) {
  SimulatorConfig config = SimulatorConfig::room_to_room();
  config.batch_size = n;
  return {in, config};
}

void begin(ContinuousEnvironment& e, std::vector<std::int64_t> chosen) { e.begin(chosen); }
void step(ContinuousEnvironment& e, std::vector<Action> actions) { e.step(actions); }

TEST(ContinuousEnvironment, TeachersArriveAndAreScored) {
  for (const auto rule : {ContinuousExpert::kReference, ContinuousExpert::kShortest}) {
    ContinuousEnvironment e = environment(2);
    begin(e, {0, 1});
    EXPECT_THAT(e.episode(), ::testing::ElementsAre(0, 1));
    EXPECT_GT(e.distance()[0], 4.0);  // around the pillar
    const double first = e.distance()[0];
    for (int k = 0; k < 100; ++k) step(e, {*e.expert(0, rule), *e.expert(1, rule)});
    EXPECT_EQ(e.expert(0, rule), Action::kStop);
    const tasks::ContinuousScore score = e.score(0);
    EXPECT_EQ(score.success, 1);
    EXPECT_LT(e.distance()[0], 0.5);
    EXPECT_DOUBLE_EQ(score.distance_to_goal, e.distance()[0]);
    EXPECT_GE(score.path_length + e.distance()[0], first - 1e-3);
    EXPECT_TRUE(e.walk(0).stopped());
    EXPECT_EQ(e.walk(0).actions.size() + 1, e.walk(0).positions.size());
  }
}

// Whoever is asked late has followed the walk from its start.
TEST(ContinuousEnvironment, TeachersKnowWhereAnAgentHasBeen) {
  ContinuousEnvironment asked = environment(1), late = environment(1);
  begin(asked, {0});
  begin(late, {0});
  for (int k = 0; k < 18; ++k) {
    const Action action = *asked.expert(0, ContinuousExpert::kReference);
    EXPECT_EQ(asked.expert(0, ContinuousExpert::kReference), action);  // twice is once
    step(asked, {action});
    step(late, {action});
  }
  EXPECT_EQ(asked.expert(0, ContinuousExpert::kReference),
            late.expert(0, ContinuousExpert::kReference));
}

TEST(ContinuousEnvironment, ScoresAsTheRunnerDoes) {
  const ContinuousWorld in = world();
  ContinuousRunOptions options;
  const auto agent = make_continuous_agent("reference");
  const auto walks = run_continuous(*agent, *in.episodes, in.buildings, options);
  const auto scores = score_continuous_walks(walks, *in.episodes, *in.buildings);
  ContinuousEnvironment e = environment(1, in);
  begin(e, {1});
  while (e.simulator().state().episode[0] == continuous::EpisodeState::kWalking) {
    step(e, {*e.expert(0, ContinuousExpert::kReference)});
  }
  EXPECT_EQ(e.walk(0), walks[1]);
  EXPECT_EQ(e.score(0).ndtw, scores[1].ndtw);
  EXPECT_EQ(e.score(0).spl, scores[1].spl);
}

TEST(ContinuousEnvironment, AgentsCanBeLeftInTheirEpisodes) {
  ContinuousEnvironment e = environment(2);
  EXPECT_THROW(begin(e, {0, -1}), ArgumentError);
  begin(e, {0, 1});
  step(e, {Action::kForward, Action::kLeft});
  begin(e, {-1, 0});
  EXPECT_THAT(e.episode(), ::testing::ElementsAre(0, 0));
  EXPECT_THAT(e.simulator().state().steps, ::testing::ElementsAre(1, 0));
  EXPECT_EQ(e.walk(0).actions.size(), 1U);
  EXPECT_TRUE(e.walk(1).actions.empty());
}

TEST(ContinuousEnvironment, HiddenGoalsHaveNoDistanceScoreOrTeacher) {
  ContinuousWorld in = world();
  tasks::ContinuousEpisodes hidden = *in.episodes;
  hidden.episodes[0].goals = {};
  hidden.episodes[0].reference_path = {};
  in.episodes = std::make_shared<const tasks::ContinuousEpisodes>(hidden);
  ContinuousEnvironment e = environment(1, in);
  begin(e, {0});
  EXPECT_TRUE(std::isnan(e.distance()[0]));
  EXPECT_EQ(e.expert(0, ContinuousExpert::kShortest), std::nullopt);
  EXPECT_THROW(e.score(0), ArgumentError);
}

TEST(ContinuousEnvironment, SaysWhatIsWrongWithItsFiles) {
  ContinuousWorld none = world();
  none.episodes = std::make_shared<const tasks::ContinuousEpisodes>();
  EXPECT_THROW(environment(1, none), ArgumentError);
  EXPECT_THROW(environment(1, {nullptr, nullptr, pillar_room()}), ArgumentError);
  EXPECT_THROW(environment(1, {world().episodes, nullptr, nullptr}), ArgumentError);
  ContinuousWorld off = world();
  tasks::ContinuousEpisodes moved = *off.episodes;
  moved.episodes[1].start.z = 9;
  off.episodes = std::make_shared<const tasks::ContinuousEpisodes>(moved);
  try {
    environment(1, off);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.diagnostics().at(0).where, "$.episodes[1].start_position");
    EXPECT_EQ(error.diagnostics().at(0).code, "start-off-floor");
  }
  moved = *world().episodes;
  moved.episodes[1].goals->front().position = {90, 0, 0};
  off.episodes = std::make_shared<const tasks::ContinuousEpisodes>(moved);
  try {
    environment(1, off);
    FAIL();
  } catch (const InvalidInput& error) {
    EXPECT_EQ(error.diagnostics().at(0).where, "$.episodes[1].goals");
    EXPECT_EQ(error.diagnostics().at(0).code, "goal-off-floor");
  }
}

TEST(ContinuousEnvironment, SaysWhatIsWrongWithACall) {
  ContinuousEnvironment e = environment(1);
  EXPECT_THROW(step(e, {Action::kForward}), ArgumentError);
  EXPECT_THROW(begin(e, {2}), ArgumentError);
  EXPECT_THROW(begin(e, {0, 0}), ArgumentError);
  EXPECT_THROW(e.expert(0, ContinuousExpert::kShortest), ArgumentError);
  EXPECT_THROW(e.score(1), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::agents
