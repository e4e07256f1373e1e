#include "enfilade/agents/panorama.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "enfilade/agents/episode_batch.h"
#include "enfilade/core/errors.h"
#include "tests/support/graphs.h"
#include "tests/support/refusal.h"

namespace enfilade::agents {
namespace EN_UNIT {

// Corners of a square of side 2 m, 0 to 3, each beside the next; it begins at 0 and looks east.
tasks::EpisodeSet square_episodes() {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::square());
  tasks::EpisodeSet set;
  set.graphs = graph::GraphSet::of(std::move(graphs));
  set.paths = {{0, ScanIndex(0), degrees(90), {ViewpointIndex(0), ViewpointIndex(2)}}};
  set.episodes = {{"0_0", 0, 0, "walk"}};
  return set;
}

// Where the agent has been, a number an action, until its way is done.
std::vector<std::uint32_t> walked(Turning turning, const std::vector<ViewpointIndex>& way) {
  const tasks::EpisodeSet episodes = square_episodes();
  EpisodeBatch batch(episodes, sim::SimulatorConfig::room_to_room());
  PanoramaCache panoramas(episodes.graphs);
  const std::array<std::size_t, 1> first{0};
  batch.begin(first);
  Route route(turning);
  route.set(way);
  std::vector<std::uint32_t> places;
  for (;;) {
    const Observation seen = batch.observation(0);
    const auto next = route.next(seen, panoramas.at({ScanIndex(0), seen.viewpoint}));
    if (!next) return places;
    const std::array<sim::Action, 1> action{
        {{next->index, next->heading_change, next->elevation_change}}};
    batch.step(action);
    places.push_back(batch.state().viewpoint[0].value);
  }
}

TEST(Route, WalksTheWholeWayTurnByTurn) {
  const ViewpointIndex one(1), two(2), zero(0);
  const auto there = walked(Turning::kRight, {one, two});
  ASSERT_FALSE(there.empty());
  EXPECT_EQ(there.back(), 2U);
  EXPECT_EQ(std::ranges::count(there, 2U), 1) << "it is done when it is there";
  EXPECT_TRUE(walked(Turning::kRight, {}).empty());
  EXPECT_TRUE(walked(Turning::kRight, {zero}).empty()) << "it stands there";
  const auto right = walked(Turning::kRight, {one, two, one, zero});
  const auto shorter = walked(Turning::kShorter, {one, two, one, zero});
  EXPECT_EQ(right.back(), 0U);
  EXPECT_EQ(shorter.back(), 0U);
  EXPECT_LT(shorter.size(), right.size()) << "one corner of this way is to the left";
}

TEST(Route, RefusesWhatIsNoNeighbour) {
  EXPECT_THAT(tests::refusal<ArgumentError>([] { walked(Turning::kRight, {ViewpointIndex(2)}); }),
              ::testing::HasSubstr("cannot go to"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::agents
