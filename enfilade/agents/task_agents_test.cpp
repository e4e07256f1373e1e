// The agents on every benchmark, on a small graph with known answers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "enfilade/agents/batch_environment.h"
#include "enfilade/agents/run.h"
#include "enfilade/core/errors.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/objects.h"
#include "enfilade/tasks/score_table.h"
#include "tests/support/graphs.h"

namespace enfilade::agents {
namespace EN_UNIT {

using tasks::Task;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr ViewpointIndex v(std::size_t i) { return ViewpointIndex(i); }

tasks::ViewedObject object(std::int64_t id) {
  tasks::ViewedObject one;
  one.id = id;
  one.name = "chair";
  one.views = {3};
  one.boxes = {{10, 20, 30, 40}};
  return one;
}

// v5 and v8 see object 5; v0 to v7 another one.
std::shared_ptr<const tasks::ObjectBoxes> objects() {
  auto boxes = std::make_shared<tasks::ObjectBoxes>();
  for (int i = 0; i < 9; ++i) {
    std::vector<tasks::ViewedObject> around;
    if (i < 8) around.push_back(object(6));
    if (i == 5 || i == 8) around.push_back(object(5));
    boxes->add("grid", "v" + std::to_string(i), around);
  }
  return boxes;
}

tasks::NamedBox box(const std::string& viewpoint) {
  tasks::NamedBox one{viewpoint, "chair", {Radians(1), Radians(0)}, {}};
  const auto corner = [](double heading, double elevation) {
    return tasks::Direction{Radians(heading), Radians(elevation)};
  };
  one.corners = {corner(0.8, 0.2), corner(1.2, 0.2), corner(1.2, -0.2), corner(0.8, -0.2)};
  return one;
}

// From v0 along the edges of the grid to v8, which is not the shortest way: 24 m for 16 m.
tasks::PathAnnotation winding(tasks::NamedGoal goal) {
  tasks::PathAnnotation path;
  path.path_id = 7;
  path.scan = "grid";
  path.path = {"v0", "v1", "v2", "v5", "v4", "v7", "v8"};
  path.instructions = {"Go.", "Walk.", "Move."};
  path.goal = std::move(goal);
  return path;
}

tasks::NamedGoal goal_of(Task task) {
  if (task == Task::kReverie) return tasks::NamedObject{5};
  if (task == Task::kCvdn)
    return tasks::NamedRegion{"chair", {"v8", "v7"}, {"v0", "v8"}, {"v0", "v7"}};
  if (task == Task::kSoon) return tasks::NamedBoxes{{box("v5"), box("v8")}, {}};
  return tasks::NearEnd{};
}

tasks::EpisodeSet episodes_of(Task task) {
  tasks::Annotations annotations{"made", "made.json", {winding(goal_of(task))}, task};
  if (task == Task::kR2rBack) {
    annotations.paths[0].path = {"v0", "v1", "v2", "v1", "v0"};
    annotations.paths[0].goal = tasks::NamedTurningPoint{"v2"};
  }
  const auto boxes = objects();
  auto set = tasks::make_episodes(annotations, graph::testing::grid(), tasks::Instructions::kScored,
                                  boxes.get());
  if (task == Task::kReverie) set.objects = boxes;
  return set;
}

constexpr std::array kTasks{Task::kR2r, Task::kR2rLast, Task::kR2rBack, Task::kR4r,
                            Task::kRxr, Task::kReverie, Task::kCvdn,    Task::kSoon};

std::vector<tasks::Trajectory> run(const char* agent, const tasks::EpisodeSet& episodes,
                                   std::uint64_t seed = 1) {
  RunOptions options;
  options.seed = seed;
  return run_agent(*make_agent(agent), episodes, options);
}

// The mean of a metric of the first scorer of the task that has one of these names.
double mean_of(const std::vector<tasks::Trajectory>& trajectories,
               const tasks::EpisodeSet& episodes, const std::string& metric,
               std::string_view scorer = {}) {
  const auto& by = tasks::benchmark(episodes.task).scorer(scorer);
  const tasks::ScoreOptions options{.bootstrap_samples = 0};
  return compute_score(trajectories, episodes, by, options).mean(metric).mean;
}

double success_of(const std::vector<tasks::Trajectory>& trajectories,
                  const tasks::EpisodeSet& episodes) {
  if (episodes.task == Task::kReverie) {
    return 100 * mean_of(trajectories, episodes, "success_rate");
  }
  const bool hamt = episodes.task == Task::kCvdn || episodes.task == Task::kR2r;
  return mean_of(trajectories, episodes, "sr", hamt ? "hamt" : "");
}

std::vector<ViewpointIndex> moves(const tasks::Trajectory& trajectory) {
  std::vector<ViewpointIndex> places;
  for (const tasks::TrajectoryPoint& point : trajectory.points) {
    if (places.empty() || places.back() != point.viewpoint) places.push_back(point.viewpoint);
  }
  return places;
}

TEST(ShortestAgent, ArrivesInEveryTask) {
  for (const Task task : kTasks) {
    const auto episodes = episodes_of(task);
    EXPECT_DOUBLE_EQ(success_of(run("shortest", episodes), episodes), 100) << int(task);
  }
}

TEST(ShortestAgent, AnswersTruly) {
  const auto reverie = episodes_of(Task::kReverie);
  EXPECT_EQ(mean_of(run("shortest", reverie), reverie, "rgs"), 1);
  const auto soon = episodes_of(Task::kSoon);
  EXPECT_EQ(mean_of(run("shortest", soon), soon, "det_sr"), 100);
  const auto back = episodes_of(Task::kR2rBack);
  for (const tasks::Trajectory& one : run("shortest", back)) {
    EXPECT_EQ(one.turning_point, v(2));
    EXPECT_EQ(moves(one), (std::vector{v(0), v(1), v(2), v(1), v(0)}));
  }
}

TEST(ShortestAgent, GoesToTheNearestViewpointThatWillDo) {
  for (const auto& [task, end] : {std::pair(Task::kReverie, 5U), std::pair(Task::kCvdn, 7U),
                                  std::pair(Task::kSoon, 5U), std::pair(Task::kR4r, 8U)}) {
    EXPECT_EQ(moves(run("shortest", episodes_of(task)).at(0)).back(), v(end)) << int(task);
  }
  const auto cvdn = episodes_of(Task::kCvdn);
  EXPECT_EQ(mean_of(run("shortest", cvdn), cvdn, "gp", "hamt"), 12);
}

TEST(ShortestAgent, NeedsTheBoxesOfReverie) {
  tasks::Annotations annotations{
      "made", "made.json", {winding(tasks::NamedObject{5})}, Task::kReverie};
  EXPECT_THAT([&] { run("shortest", tasks::make_episodes(annotations, graph::testing::grid())); },
              ThrowsMessage<ArgumentError>(HasSubstr("made without boxes")));
}

TEST(ReferenceAgent, WalksThePathOfTheAnnotation) {
  for (const Task task : kTasks) {
    const auto episodes = episodes_of(task);
    const auto trajectories = run("reference", episodes);
    for (const tasks::Trajectory& one : trajectories) {
      EXPECT_EQ(moves(one), episodes.paths[0].viewpoints) << int(task);
    }
    EXPECT_DOUBLE_EQ(success_of(trajectories, episodes), 100) << int(task);
  }
  const auto reverie = episodes_of(Task::kReverie);
  EXPECT_EQ(mean_of(run("reference", reverie), reverie, "rgs"), 1);
}

TEST(ReferenceAgent, TakesTheShortestPathBetweenViewpointsWithoutAnEdge) {
  tasks::Annotations annotations{"made", "made.json", {winding(goal_of(Task::kSoon))}, Task::kSoon};
  annotations.paths[0].path = {"v0", "v2", "v8"};
  const auto episodes = tasks::make_episodes(annotations, graph::testing::grid());
  EXPECT_EQ(moves(run("reference", episodes).at(0)), (std::vector{v(0), v(1), v(2), v(5), v(8)}));
}

TEST(RandomAgent, AnswersAtRandomWithoutAnotherWalk) {
  const auto r2r = run("random", episodes_of(Task::kR4r));
  for (const Task task : {Task::kReverie, Task::kSoon}) {
    const auto answered = run("random", episodes_of(task));
    // The path's id names no stream; the instruction's does, and it is the same in all of them.
    EXPECT_EQ(moves(answered.at(0)), moves(r2r.at(0)));
  }
  std::size_t named = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    for (const auto& one : run("random", episodes_of(Task::kReverie), seed)) {
      const bool known = one.object == "5" || one.object == "6";
      EXPECT_TRUE(known) << one.object;
      named += one.object == "5" ? 1 : 0;
    }
    for (const auto& one : run("random", episodes_of(Task::kSoon), seed)) {
      ASSERT_TRUE(one.point.has_value());
      EXPECT_TRUE(one.point->heading >= 0 && one.point->heading < 1);
      EXPECT_TRUE(one.point->elevation >= 0.25 && one.point->elevation <= 0.75);
    }
    for (const auto& one : run("random", episodes_of(Task::kR2rBack), seed)) {
      EXPECT_THAT(moves(one), ::testing::Contains(one.turning_point.value()));
    }
  }
  EXPECT_GT(named, 0U);
  EXPECT_LT(named, 60U);
}

TEST(RandomAgent, NamesNothingWhereThereAreNoObjects) {
  auto episodes = episodes_of(Task::kReverie);
  episodes.objects = nullptr;
  for (const auto& one : run("random", episodes)) EXPECT_EQ(one.object, "");
}

// Walks to these viewpoints in an environment, then stops.
double walk(BatchEnvironment& environment, const std::vector<std::size_t>& path) {
  environment.reset({}, std::array<std::int64_t, 1>{0});
  double reward = 0;
  for (const std::size_t next : path) {
    for (std::int64_t k = 0; k < environment.state().navigable_count[0]; ++k) {
      if (environment.state().navigable_viewpoint[static_cast<std::size_t>(k)] != v(next)) continue;
      environment.step(std::array{k});
      break;
    }
    reward += environment.outcome().reward[0];
  }
  environment.step(std::array<std::int64_t, 1>{0});
  return reward + environment.outcome().reward[0];
}

BatchEnvironment environment_of(Task task) {
  return BatchEnvironment(std::make_shared<tasks::EpisodeSet>(episodes_of(task)), {});
}

TEST(BatchEnvironment, JudgesByTheGoalOfAnyTask) {
  BatchEnvironment reverie = environment_of(Task::kReverie);
  EXPECT_DOUBLE_EQ(walk(reverie, {1, 2, 5}), 12 + 2);
  EXPECT_EQ(reverie.outcome().success[0], 1);
  EXPECT_EQ(reverie.outcome().spl[0], 1) << "REVERIE's scorer compares with the path's end";
  EXPECT_DOUBLE_EQ(walk(reverie, {1, 4}), 8 - 2);
  EXPECT_EQ(reverie.outcome().success[0], 0);
  BatchEnvironment cvdn = environment_of(Task::kCvdn);
  EXPECT_DOUBLE_EQ(walk(cvdn, {3, 4, 7, 8}), 12 + 2);
  EXPECT_DOUBLE_EQ(cvdn.outcome().spl[0], 0.75);
  BatchEnvironment soon = environment_of(Task::kSoon);
  EXPECT_DOUBLE_EQ(walk(soon, {1, 2, 5}), 12 + 2);
  EXPECT_EQ(soon.outcome().spl[0], 1);
}

TEST(BatchEnvironment, OfR2rBackHasTwoLegs) {
  BatchEnvironment back = environment_of(Task::kR2rBack);
  EXPECT_DOUBLE_EQ(walk(back, {1, 2, 1, 0}), 16 + 2);
  EXPECT_EQ(back.outcome().success[0], 1);
  EXPECT_EQ(back.outcome().spl[0], 1);
  EXPECT_DOUBLE_EQ(walk(back, {1, 0}), 0 - 2);
  EXPECT_EQ(back.outcome().success[0], 0);
}

}  // namespace EN_UNIT
}  // namespace enfilade::agents
