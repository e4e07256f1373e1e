#include "enfilade/tasks/split.h"

#include <gmock/gmock.h>
#include <memory>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/core/errors.h"
#include "tests/support/graphs.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

// A square of side 2 m; "1_0" goes along one side, "1_1" too.
Split on_square() {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square());
  Annotations annotations;
  annotations.split = "made";
  PathAnnotation path;
  path.path_id = 1;
  path.scan = "square";
  path.path = {"v0", "v1"};
  path.distance = 2;
  path.instructions = {"Go east.", "Walk along the wall."};
  annotations.paths = {path};
  return Split(make_episodes(annotations, graph::GraphSet::of(std::move(graphs))));
}

Split on_floor(std::string_view benchmark_name) {
  auto all = std::make_shared<ContinuousEpisodes>();
  all->split = "made";
  ContinuousEpisode& one = all->episodes.emplace_back();
  one.id = 7;
  one.scene = "mp3d/room/room.glb";
  one.instruction.id = 7;
  one.goals = {{.position = {3, 4, 0}, .radius = 3}};
  one.reference_path = {{0, 0, 0}, {3, 0, 0}, {3, 4, 0}};
  return {benchmark(benchmark_name), std::move(all)};
}

TEST(Split, SaysTheSameOfBothWorlds) {
  const Split graph = on_square(), floor = on_floor("r2r-ce");
  EXPECT_EQ(graph.benchmark().name, "r2r");
  EXPECT_EQ(floor.benchmark().name, "r2r-ce");
  EXPECT_EQ(graph.name(), "made");
  EXPECT_EQ(floor.name(), "made");
  EXPECT_EQ(graph.size(), 2U);
  EXPECT_EQ(floor.size(), 1U);
  EXPECT_EQ(graph.id(1), "1_1");
  EXPECT_EQ(floor.id(0), "7");
  EXPECT_FALSE(graph.goals_hidden());
  EXPECT_FALSE(floor.goals_hidden());
  const PathSize side = graph.path_size(0), corner = floor.path_size(0);
  EXPECT_EQ(side.scan, "square");
  EXPECT_EQ(side.places, 2U);
  EXPECT_NEAR(side.length, 2, 1e-6);  // the file's poses are floats
  EXPECT_EQ(corner.scan, "room");
  EXPECT_EQ(corner.places, 3U);
  EXPECT_DOUBLE_EQ(corner.length, 7);
}

TEST(Split, HiddenGoalsLeaveTheStart) {
  ContinuousEpisodes hidden = *on_floor("r2r-ce").continuous();
  hidden.episodes[0].goals.reset();
  hidden.episodes[0].reference_path.reset();
  const Split split(benchmark("r2r-ce"), std::make_shared<const ContinuousEpisodes>(hidden));
  EXPECT_TRUE(split.goals_hidden());
  EXPECT_EQ(split.path_size(0).places, 1U);
  EXPECT_EQ(split.path_size(0).length, 0);
  EXPECT_TRUE(split.experts()->empty());
}

TEST(Split, IsOfEpisodes) {
  EXPECT_THAT([] { Split(std::shared_ptr<const EpisodeSet>()); },
              ThrowsMessage<ArgumentError>(HasSubstr("episodes")));
  EXPECT_THAT([] { Split(benchmark("r2r-ce"), nullptr); },
              ThrowsMessage<ArgumentError>(HasSubstr("episodes")));
}

TEST(Trajectories, AreWrittenInTheFormOfTheBenchmarkAndReadBack) {
  const Split graph = on_square();
  const Trajectories two = std::vector<Trajectory>{
      {.episode = 0, .points = {{ViewpointIndex(0), {}, {}}, {ViewpointIndex(1), {}, {}}}},
      {.episode = 1, .points = {{ViewpointIndex(0), {}, {}}}}};
  EXPECT_EQ(size(two), 2U);
  const std::string text = to_json(two, graph);
  EXPECT_EQ(to_json(parse_trajectories(text, "made.json", graph), graph), text);
  for (const char* name : {"r2r-ce", "rxr-ce"}) {
    const Split floor = on_floor(name);
    const Trajectories one =
        std::vector<ContinuousResult>{{.episode = 0,
                                       .positions = {{0, 0, 0}, {0, 0.25F, 0}, {0, 0.25F, 0}},
                                       .headings = {Radians(0), Radians(0), Radians(0)},
                                       .actions = {1, 0},
                                       .collided = {}}};
    const std::string walk = to_json(one, floor);
    EXPECT_EQ(walk.front(), '{') << name;
    EXPECT_EQ(size(parse_trajectories(walk, "made.json", floor)), 1U) << name;
  }
}

TEST(Trajectories, APartOfASplitIsASplit) {
  const Split graph = on_square();
  Trajectories second = std::vector<Trajectory>{
      {.episode = 1, .points = {{ViewpointIndex(0), {}, {}}, {ViewpointIndex(1), {}, {}}}}};
  const Split part = part_of(graph, second);
  EXPECT_EQ(part.size(), 1U);
  EXPECT_EQ(part.id(0), "1_1");
  EXPECT_EQ(std::get<std::vector<Trajectory>>(second)[0].episode, 0U);
  std::vector<Diagnostic> warnings;
  EXPECT_THAT([&] { parse_trajectories("[]", "none.json", graph, Coverage::kAll, &warnings); },
              ThrowsMessage<InvalidInput>(HasSubstr("none.json")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
