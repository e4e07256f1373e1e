#include "enfilade/sim/candidates.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "enfilade/core/rng.h"
#include "tests/support/graphs.h"

namespace enfilade::sim {
namespace EN_UNIT {

// Thirty viewpoints on two storeys, joined where they are near.
std::shared_ptr<const graph::GraphSet> small_set() {
  Rng rng(3);
  std::vector<Vec3d> points;
  std::vector<std::pair<int, int>> edges;
  for (int i = 0; i < 30; ++i) {
    points.push_back({rng.uniform() * 12, rng.uniform() * 8, i < 15 ? 1.5 : 4.5});
    for (int j = 0; j < i; ++j) {
      if (length(points[static_cast<std::size_t>(i)] - points[static_cast<std::size_t>(j)]) < 4) {
        edges.emplace_back(j, i);
      }
    }
  }
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(graph::testing::connectivity("made", points, edges));
  return graph::GraphSet::of(std::move(graphs));
}

// What agents do: start at view 0, turn right 35 times, up after each round.
std::vector<Candidate> by_turning(const std::shared_ptr<const graph::GraphSet>& graphs,
                                  graph::Location location) {
  Simulator simulator(graphs, SimulatorConfig::room_to_room());
  StateBuffer buffer(1, simulator.config().max_navigable);
  const StateSpans state = buffer.spans();
  std::vector<Candidate> found;
  std::map<std::uint32_t, std::size_t> place;
  for (std::uint32_t view = 0; view < 36; ++view) {
    if (view == 0) {
      const EpisodeStart start{location, Radians(0), degrees(-30)};
      simulator.new_episodes({&start, 1}, state);
    } else {
      const Action turn{0, Radians(1), Radians(view % 12 == 0 ? 1 : 0)};
      simulator.step({&turn, 1}, state);
    }
    EXPECT_EQ(state.view_index[0], view);
    for (std::uint32_t k = 1; k < state.navigable_count[0]; ++k) {
      const double right = state.navigable_rel_heading[k], up = state.navigable_rel_elevation[k];
      const Candidate candidate{state.navigable_viewpoint[k],
                                view,
                                k,
                                Radians(right),
                                Radians(up),
                                Radians(state.heading[0] + right),
                                Radians(state.elevation[0] + up),
                                std::sqrt(right * right + up * up),
                                state.navigable_distance[k]};
      const auto [known, added] = place.emplace(candidate.viewpoint.value, found.size());
      if (added) {
        found.push_back(candidate);
      } else if (candidate.angle < found[known->second].angle) {
        found[known->second] = candidate;
      }
    }
  }
  return found;
}

TEST(Candidates, AreThoseThatTurningFinds) {
  const auto graphs = small_set();
  CandidateFinder finder(graphs);
  const graph::NavGraph& graph = graphs->graph(ScanIndex(0));
  for (std::size_t v = 0; v < graph.size(); ++v) {
    const graph::Location here{ScanIndex(0), ViewpointIndex(v)};
    const std::vector<Candidate>& found = finder.find(here);
    const std::vector<Candidate> turned = by_turning(graphs, here);
    ASSERT_EQ(found.size(), turned.size());
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].viewpoint, turned[i].viewpoint);
      EXPECT_EQ(found[i].view, turned[i].view);
      EXPECT_EQ(found[i].index, turned[i].index);
      EXPECT_EQ(found[i].heading, turned[i].heading);
      EXPECT_EQ(found[i].elevation, turned[i].elevation);
      EXPECT_EQ(found[i].angle, turned[i].angle);
      EXPECT_EQ(found[i].distance, turned[i].distance);
    }
  }
}

TEST(Candidates, AreTheNeighboursEachOnceAndLookAlongTheEdge) {
  const auto graphs = small_set();
  CandidateFinder finder(graphs);
  const graph::NavGraph& graph = graphs->graph(ScanIndex(0));
  for (std::size_t v = 0; v < graph.size(); ++v) {
    const std::vector<Candidate>& found = finder.find({ScanIndex(0), ViewpointIndex(v)});
    EXPECT_EQ(found.size(), graph.edges(ViewpointIndex(v)).size());
    for (const Candidate& candidate : found) {
      const graph::Edge* edge = graph.edge(ViewpointIndex(v), candidate.viewpoint);
      ASSERT_NE(edge, nullptr);
      // Single precision of the angle to it.
      EXPECT_NEAR(wrap_difference(candidate.heading - edge->heading).value, 0, 1e-6);
      EXPECT_NEAR(candidate.elevation.value, edge->elevation.value, 1e-12);
      EXPECT_LE(std::abs(candidate.rel_heading.value), kPi / 12 + 1e-6);
    }
  }
}

TEST(Candidates, OfAnUnknownViewpointAreRefused) {
  CandidateFinder finder(small_set());
  EXPECT_THROW(finder.find({ScanIndex(0), ViewpointIndex(100000)}), ActionError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::sim
