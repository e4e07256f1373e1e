
#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "enfilade/core/detail/json.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/sim/simulator.h"
#include "tests/support/graphs.h"

namespace enfilade::sim {
namespace EN_UNIT {

TEST(MatterSimRandom, GeneratesTheStandardsNumbers) {
  for (const std::uint64_t seed : {std::uint64_t{1}, std::uint64_t{0}, std::uint64_t{42},
                                   std::uint64_t{2147483647}, std::uint64_t{2147483648}}) {
    std::minstd_rand0 theirs(seed);
    MatterSimRandom ours(seed);
    for (int i = 0; i < 1000; ++i) ASSERT_EQ(ours.next(), theirs()) << seed;
  }
  // The C++ standard: the 10000th number of a default-made minstd_rand0.
  MatterSimRandom ours;
  for (int i = 1; i < 10000; ++i) ours.next();
  EXPECT_EQ(ours.next(), 1043618065U);
}

TEST(MatterSimRandom, BelowDividesAfterRejecting) {
  // 2^31 - 3 possible values fall into n equal parts, the rest is drawn again.
  MatterSimRandom raw(7), ours(7);
  constexpr std::uint32_t kN = 1'500'000'000;  // one part; every third number is drawn again
  for (int i = 0; i < 1000; ++i) {
    std::uint32_t x = raw.next() - 1;
    while (x >= kN) x = raw.next() - 1;
    ASSERT_EQ(ours.below(kN), x);
  }
  EXPECT_EQ(MatterSimRandom(5).below(1), 0U);
}

TEST(MatterSimRandom, HeadingsBeginAsRecorded) {
  MatterSimRandom random;  // what every agent 0, 1, 2 of MatterSim starts with
  EXPECT_EQ(random.heading().value, 0.8264762952590881);
  EXPECT_EQ(random.heading().value, 2.881783770664272);
  EXPECT_EQ(random.heading().value, 1.3757611416822468);
}

TEST(MatterSimRandom, StartsAfterExcludedViewpointsAreLikelier) {
  scan::Connectivity c = graph::testing::square();
  c.entries[0].included = c.entries[1].included = false;  // 2 takes their draws
  const auto graphs = graph::GraphSet::of([&] {
    std::vector<graph::NavGraph> list;
    list.emplace_back(c);
    return list;
  }());
  Simulator simulator(graphs, SimulatorConfig::mattersim());
  StateBuffer buffer(1, 32);
  const ScanIndex scan(0);
  int at_2 = 0;
  for (int i = 0; i < 1000; ++i) {
    simulator.new_random_episodes({&scan, 1}, buffer.spans());
    at_2 += buffer.spans().viewpoint[0] == ViewpointIndex(2) ? 1 : 0;
    ASSERT_EQ(buffer.spans().heading[0], 0.8264762952590881) << "the same at every call";
  }
  EXPECT_NEAR(at_2, 750, 60);  // 4 standard deviations of 1000 draws with probability 3/4: 55
}

// Recorded episodes: {seed, discretized, scans, calls: [[[scan, viewpoint, ix, heading, elevation,
// viewIndex] for each agent] for each call]}.
class Recorded {
 public:
  explicit Recorded(std::shared_ptr<const graph::GraphSet> graphs) : graphs_(std::move(graphs)) {}

  void replay(json::Element run) {
    SimulatorConfig config = SimulatorConfig::mattersim();
    std::int64_t seed = 1;  // null: MatterSim's default
    if (!run["seed"].is_null()) seed = run["seed"].get_int64().value_unsafe();
    config.seed = static_cast<std::uint64_t>(seed);
    config.viewing =
        run["discretized"].get_bool().value_unsafe() ? Viewing::kDiscretized : Viewing::kContinuous;
    std::vector<ScanIndex> scans;
    for (const auto scan : run["scans"].get_array()) {
      scans.push_back(graphs_->at(scan.get_string().value_unsafe()));
    }
    config.batch_size = scans.size();
    Simulator simulator(graphs_, config);
    StateBuffer buffer(config.batch_size, config.max_navigable);
    for (const auto call : run["calls"].get_array()) {
      simulator.new_random_episodes(scans, buffer.spans());
      std::size_t agent = 0;
      for (const auto expected : call.get_array()) compare(expected, buffer.spans(), agent++);
    }
  }
  int starts() const { return starts_; }

 private:
  void compare(json::Element expected, const StateSpans& got, std::size_t agent) {
    const graph::NavGraph& graph = graphs_->graph(got.scan[agent]);
    const ViewpointIndex viewpoint = got.viewpoint[agent];
    EXPECT_EQ(graph.scan(), expected.at(0).get_string().value_unsafe());
    EXPECT_EQ(graph.id(viewpoint), expected.at(1).get_string().value_unsafe());
    EXPECT_EQ(viewpoint.value, expected.at(2).get_uint64().value_unsafe());
    EXPECT_EQ(std::bit_cast<std::uint64_t>(got.heading[agent]),
              std::bit_cast<std::uint64_t>(expected.at(3).get_double().value_unsafe()));
    EXPECT_EQ(got.elevation[agent], expected.at(4).get_double().value_unsafe());
    EXPECT_EQ(got.view_index[agent], expected.at(5).get_uint64().value_unsafe());
    ++starts_;
  }

  std::shared_ptr<const graph::GraphSet> graphs_;
  int starts_ = 0;
};

TEST(MatterSimRandom, RecordedEpisodesStartTheSameToTheBit) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no real graphs";
  const auto file = data->folder() / ".." / "reference" / "random_episodes.json";
  if (!std::filesystem::exists(file)) {
    GTEST_SKIP() << "no recorded random episodes beside the data: " << file;
  }
  Recorded recorded(graph::GraphSet::open_shared(data->connectivity()));
  const auto document = json::Document::load(file);
  for (const auto run : document.root().get_array()) recorded.replay(run);
  EXPECT_GT(recorded.starts(), 900);
}

}  // namespace EN_UNIT
}  // namespace enfilade::sim
