#include "enfilade/sim/observe.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "enfilade/core/errors.h"
#include "enfilade/sim/simulator.h"
#include "tests/support/graphs.h"
#include "tests/support/made_panoramas.h"

namespace enfilade::sim {
namespace EN_UNIT {

// The square of tests/support, with panoramas; agents walk it and see.
struct World {
  std::shared_ptr<const graph::GraphSet> graphs;
  std::shared_ptr<render::FaceCache> faces;

  World() {
    std::vector<graph::NavGraph> all;
    all.emplace_back(graph::testing::square("made"));
    const std::size_t count = all.front().size();
    graphs = graph::GraphSet::of(std::move(all));
    faces = render::testing::made_cache(16, count);
  }
};

TEST(Observe, ViewsAreWhereTheAgentsAre) {
  const World world;
  SimulatorConfig config;
  config.batch_size = 2;
  Simulator simulator(world.graphs, config);
  StateBuffer state(2, config.max_navigable);
  const std::vector<EpisodeStart> starts{
      {{ScanIndex(0), ViewpointIndex(0)}, Radians(0.5), Radians(0.1)},
      {{ScanIndex(0), ViewpointIndex(2)}, Radians(1.5), Radians(-0.1)}};
  simulator.new_episodes(starts, state.spans());
  std::vector<render::View> views(2);
  views_of(state.spans(), views);
  EXPECT_EQ(views[1].viewpoint, ViewpointIndex(2));
  EXPECT_EQ(views[0].heading.value, 0.5);
  EXPECT_EQ(views[1].elevation.value, -0.1);

  const Camera camera{20, 15, degrees(60)};
  render::testing::Pictures out(camera, 2);
  render::make_renderer(world.faces)->render(camera, views, out.outputs());
  EXPECT_NE(out.instances.front(), 0U);
  views.resize(1);
  EXPECT_THROW(views_of(state.spans(), views), ArgumentError);
}

TEST(Observe, NeighboursAreDecodedAhead) {
  const World world;
  SimulatorConfig config;
  config.navigation = Navigation::kUnrestricted;
  Simulator simulator(world.graphs, config);
  StateBuffer state(1, config.max_navigable);
  const EpisodeStart start{{ScanIndex(0), ViewpointIndex(0)}, Radians(0), Radians(0)};
  simulator.new_episodes({&start, 1}, state.spans());
  ASSERT_GT(state.spans().navigable_count[0], 1U);
  const Camera camera{20, 15, degrees(60)};
  const std::array layers{scan::Layer::kColour};
  prefetch_neighbours(state.spans(), config.max_navigable, camera, layers, *world.faces);
  const auto limit = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (world.faces->counters().prefetched == 0 && std::chrono::steady_clock::now() < limit) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_GT(world.faces->counters().prefetched, 0U);
  EXPECT_EQ(world.faces->counters().misses, 0U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::sim
