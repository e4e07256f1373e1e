// Long random walks: against the plain oracle, at every batch size and thread count, and without
// touching the heap.
#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/sim/simulator.h"
#include "tests/support/graphs.h"
#include "tests/support/reference_navigable.h"

// GCC defines __SANITIZE_*__, clang tells through __has_feature.
#if defined(__has_feature)
#define EN_HAS_FEATURE(feature) __has_feature(feature)
#else
#define EN_HAS_FEATURE(feature) 0
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) || \
    EN_HAS_FEATURE(address_sanitizer) || EN_HAS_FEATURE(thread_sanitizer)
#define EN_TEST_SANITIZED 1
#else
#define EN_TEST_SANITIZED 0
#endif

#if !EN_TEST_SANITIZED  // sanitizers bring their own
namespace {
thread_local std::size_t allocations = 0;
}  // namespace

// Not inlined: gcc would see malloc's memory freed by one half of a pair and warn of a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
#endif

namespace enfilade::sim {
namespace EN_UNIT {

using graph::GraphSet;
using graph::NavGraph;

// Viewpoints on three storeys, some on top of each other, up to 20 edges each, some excluded.
scan::Connectivity random_building(std::uint64_t seed) {
  Rng rng(seed);
  std::vector<Vec3d> points;
  std::vector<std::pair<int, int>> edges;
  constexpr int kSize = 60;
  for (int i = 0; i < kSize; ++i) {
    // Whole metres: many ties, vertical edges and coincident viewpoints.
    points.push_back({static_cast<double>(rng.below(6)), static_cast<double>(rng.below(6)),
                      static_cast<double>(rng.below(3)) * 3});
    if (seed % 2 == 0) {
      points.back().x += rng.uniform();
      points.back().y += rng.uniform();
    }
    const auto degree = static_cast<int>(rng.below(10));
    for (int k = 0; k < degree; ++k) edges.emplace_back(i, static_cast<int>(rng.below(kSize)));
  }
  auto connectivity = graph::testing::connectivity("s" + std::to_string(seed), points, edges);
  for (auto& entry : connectivity.entries) entry.included = rng.below(10) > 0;
  return connectivity;
}

std::shared_ptr<const GraphSet> random_buildings() {
  std::vector<NavGraph> graphs;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) graphs.emplace_back(random_building(seed));
  return GraphSet::of(std::move(graphs));
}

std::vector<SimulatorConfig> all_modes() {
  std::vector<SimulatorConfig> modes;
  for (const Viewing viewing : {Viewing::kContinuous, Viewing::kDiscretized}) {
    for (const Navigation navigation : {Navigation::kRestricted, Navigation::kUnrestricted}) {
      for (const FieldOfView field : {FieldOfView::kPerspective, FieldOfView::kLinear}) {
        SimulatorConfig config;
        config.viewing = viewing;
        config.navigation = navigation;
        config.field_of_view = field;
        config.max_navigable = 64;
        modes.push_back(config);
      }
    }
  }
  return modes;
}

// One agent's action depends on its stream and its list only, not on who else is there.
Action random_action(Rng& rng, std::uint32_t count) {
  Action action;
  action.index = static_cast<std::uint32_t>(rng.below(count));
  action.heading_change = Radians((rng.uniform() - 0.5) * (rng.below(20) == 0 ? 100 : 4));
  action.elevation_change = Radians(rng.uniform() - 0.5);
  if (rng.below(4) == 0) action.heading_change = Radians(0);
  return action;
}

// A batch that walks at random from random starts.
class Walk {
 public:
  Walk(const std::shared_ptr<const GraphSet>& graphs, const SimulatorConfig& config)
      : simulator_(graphs, config),
        buffer_(config.batch_size, config.max_navigable),
        actions_(config.batch_size) {
    std::vector<ScanIndex> scans;
    for (std::size_t i = 0; i < config.batch_size; ++i) {
      scans.emplace_back(i % graphs->size());
      rngs_.emplace_back(99, i);
    }
    simulator_.new_random_episodes(scans, out());
  }

  void choose() {
    for (std::size_t i = 0; i < actions_.size(); ++i) {
      actions_[i] = random_action(rngs_[i], out().navigable_count[i]);
    }
  }
  void step() { simulator_.step(actions_, out()); }
  StateSpans out() { return buffer_.spans(); }
  const std::vector<Action>& actions() const { return actions_; }

  // Everything that agent i is shown, as bits.
  std::vector<std::uint64_t> bits(std::size_t i) {
    const StateSpans s = out();
    std::vector<std::uint64_t> all{s.scan[i].value,
                                   s.viewpoint[i].value,
                                   std::bit_cast<std::uint64_t>(s.heading[i]),
                                   std::bit_cast<std::uint64_t>(s.elevation[i]),
                                   s.view_index[i],
                                   s.step[i],
                                   s.navigable_count[i]};
    for (std::size_t k = 0; k < s.navigable_count[i]; ++k) {
      const std::size_t at = i * buffer_.spans().max_navigable() + k;
      all.push_back(s.navigable_viewpoint[at].value);
      all.push_back(std::bit_cast<std::uint64_t>(s.navigable_rel_heading[at]));
      all.push_back(std::bit_cast<std::uint64_t>(s.navigable_rel_elevation[at]));
      all.push_back(std::bit_cast<std::uint64_t>(s.navigable_distance[at]));
    }
    return all;
  }

 private:
  Simulator simulator_;
  StateBuffer buffer_;
  std::vector<Action> actions_;
  std::vector<Rng> rngs_;
};

double half_width(const SimulatorConfig& config) {
  if (config.field_of_view == FieldOfView::kPerspective) {
    return horizontal_field_of_view(config.camera).value / 2;
  }
  return config.camera.vertical_field_of_view.value * config.camera.width / config.camera.height /
         2;
}

// The list of agent i is the oracle's, in values and order, to the bit.
void expect_reference_list(const GraphSet& graphs, const SimulatorConfig& config,
                           const StateSpans& out, std::size_t i) {
  const auto expected = tests::reference_navigable(
      graphs.graph(out.scan[i]), out.viewpoint[i], out.heading[i], out.elevation[i],
      config.navigation == Navigation::kRestricted, half_width(config));
  ASSERT_EQ(out.navigable_count[i], expected.size());
  for (std::size_t k = 0; k < expected.size(); ++k) {
    const std::size_t at = i * config.max_navigable + k;
    const tests::ReferenceNavigable got{out.navigable_viewpoint[at], out.navigable_rel_heading[at],
                                        out.navigable_rel_elevation[at],
                                        out.navigable_distance[at]};
    ASSERT_EQ(got, expected[k]) << "entry " << k;
  }
}

// Walks a batch and checks moves, turns and lists of every agent at every step.
void expect_reference_walk(const std::shared_ptr<const GraphSet>& graphs, SimulatorConfig config,
                           std::size_t batch, int steps) {
  config.batch_size = batch;
  Walk walk(graphs, config);
  const StateSpans out = walk.out();
  for (int step = 0; step < steps; ++step) {
    walk.choose();
    std::vector<ViewpointIndex> targets;
    std::vector<double> headings;
    for (std::size_t i = 0; i < batch; ++i) {
      const Action& action = walk.actions()[i];
      targets.push_back(out.navigable_viewpoint[i * config.max_navigable + action.index]);
      headings.push_back(out.heading[i] + action.heading_change.value);
    }
    walk.step();
    for (std::size_t i = 0; i < batch; ++i) {
      ASSERT_EQ(out.viewpoint[i], targets[i]);
      ASSERT_EQ(out.step[i], static_cast<std::uint32_t>(step + 1));
      if (config.viewing == Viewing::kContinuous) {
        ASSERT_EQ(out.heading[i], wrap_heading(Radians(headings[i])).value);
      } else {
        ASSERT_EQ(out.heading[i], (out.view_index[i] % 12) * (2 * kPi / 12));
      }
      ASSERT_NO_FATAL_FAILURE(expect_reference_list(*graphs, config, out, i));
    }
  }
}

TEST(SimulatorWalk, AgreesWithTheOracleToTheBit) {
  const auto graphs = random_buildings();
  for (const SimulatorConfig& mode : all_modes()) {
    ASSERT_NO_FATAL_FAILURE(expect_reference_walk(graphs, mode, 37, 100));
  }
}

TEST(SimulatorWalk, AgreesWithTheOracleInRealBuildings) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real graphs";
  const auto graphs = GraphSet::open_shared(data->connectivity());
  for (const SimulatorConfig& mode : all_modes()) {
    ASSERT_NO_FATAL_FAILURE(expect_reference_walk(graphs, mode, 90, 60));
  }
}

TEST(SimulatorWalk, IsTheSameInAnyBatch) {
  const auto graphs = random_buildings();
  for (SimulatorConfig config : all_modes()) {
    // Agents 0 to 4 of batches of 5 and of 40; the same buildings, seeds and choices.
    config.batch_size = 5;
    Walk small(graphs, config);
    config.batch_size = 40;
    Walk large(graphs, config);
    for (int step = 0; step < 30; ++step) {
      for (std::size_t i = 0; i < 5; ++i) ASSERT_EQ(small.bits(i), large.bits(i)) << step;
      small.choose();
      large.choose();
      small.step();
      large.step();
    }
  }
}

TEST(SimulatorWalk, IsTheSameOnAnyNumberOfThreads) {
  const auto graphs = random_buildings();
  for (SimulatorConfig config : all_modes()) {
    config.batch_size = 3000;  // three shares
    config.max_navigable = 32;
    Walk one(graphs, config);
    config.threads = 2;
    Walk two(graphs, config);
    for (int step = 0; step < 3; ++step) {
      one.choose();
      two.choose();
      one.step();
      two.step();
      for (std::size_t i = 0; i < config.batch_size; ++i) ASSERT_EQ(one.bits(i), two.bits(i));
    }
  }
}

TEST(SimulatorWalk, SteppingAllocatesNothing) {
#if EN_TEST_SANITIZED
  GTEST_SKIP() << "the sanitizer's own allocator is not counted";
#else
  const auto graphs = random_buildings();
  for (SimulatorConfig config : all_modes()) {
    config.batch_size = 50;
    Walk walk(graphs, config);
    const std::size_t before = allocations;
    for (int step = 0; step < 20; ++step) {
      walk.choose();
      walk.step();
    }
    EXPECT_EQ(allocations, before);
  }
  const std::size_t before = allocations;
  auto counted = std::make_unique<int>(1);
  EXPECT_EQ(allocations, before + 1) << "the count itself works";
#endif
}

TEST(SimulatorWalk, RandomStartsAreUniformAndIncluded) {
  scan::Connectivity c = graph::testing::square();
  c.entries[1].included = false;
  std::vector<NavGraph> list;
  list.emplace_back(c);
  const auto graphs = GraphSet::of(std::move(list));
  SimulatorConfig config;
  config.batch_size = 3000;
  config.max_navigable = 4;
  Simulator simulator(graphs, config);
  StateBuffer buffer(config.batch_size, config.max_navigable);
  simulator.new_random_episodes(std::vector(config.batch_size, ScanIndex(0)), buffer.spans());
  std::array<int, 4> viewpoints{};
  std::array<int, 4> quadrants{};
  for (std::size_t i = 0; i < config.batch_size; ++i) {
    ++viewpoints[buffer.spans().viewpoint[i].at()];
    ++quadrants.at(static_cast<std::size_t>(buffer.spans().heading[i] / (kPi / 2)));
    ASSERT_EQ(buffer.spans().elevation[i], 0);
  }
  EXPECT_EQ(viewpoints[1], 0);
  // 4 standard deviations of 3000 draws: 103 for thirds, 95 for quarters.
  for (const std::size_t k : {0U, 2U, 3U}) EXPECT_NEAR(viewpoints.at(k), 1000, 103);
  for (const int count : quadrants) EXPECT_NEAR(count, 750, 95);
}

TEST(SimulatorWalk, RandomStartsAreAStreamForEachAgent) {
  const auto graphs = random_buildings();
  SimulatorConfig config;
  config.batch_size = 2;
  config.max_navigable = 64;
  Simulator together(graphs, config);
  StateBuffer a(2, 64), b(2, 64);
  const std::vector scans{ScanIndex(3), ScanIndex(4)};
  Simulator again(graphs, config);
  const std::vector others{ScanIndex(2), ScanIndex(4)};
  for (int episode = 0; episode < 5; ++episode) {
    together.new_random_episodes(scans, a.spans());
    again.new_random_episodes(others, b.spans());
    EXPECT_EQ(a.spans().viewpoint[1], b.spans().viewpoint[1]);
    EXPECT_EQ(a.spans().heading[1], b.spans().heading[1]);
  }
  config.seed = 2;
  Simulator other(graphs, config);
  other.new_random_episodes(scans, b.spans());
  EXPECT_NE(a.spans().heading[1], b.spans().heading[1]);
}

}  // namespace EN_UNIT
}  // namespace enfilade::sim
