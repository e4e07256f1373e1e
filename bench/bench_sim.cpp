// Agent-steps a second: random valid actions, the whole state of every agent written, no pictures.
// Arguments: batch, viewing (0 continuous, 1 discretized), unrestricted, scans (1 or all), threads.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bench/main.h"
#include "enfilade/core/rng.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/sim/simulator.h"

namespace enfilade {
namespace {

using sim::Action;
using sim::Simulator;
using sim::SimulatorConfig;

std::shared_ptr<const graph::GraphSet> real_graphs() {
  static const std::shared_ptr<const graph::GraphSet> kGraphs = [] {
    auto set = graph::GraphSet::open(scan::DataRoot::from_environment()->connectivity());
    set->load_all();
    return set;
  }();
  return kGraphs;
}

// Numbers drawn beforehand, so that what is timed is the simulator.
class Walk {
 public:
  explicit Walk(std::size_t batch) : actions_(batch) {
    Rng rng(1);
    for (Draw& draw : draws_) {
      draw = {rng.next() >> 32U, Radians((rng.uniform() - 0.5) * 2 * kPi),
              Radians((rng.uniform() - 0.5))};
    }
  }

  // Any entry of each agent's navigable list with the same probability, and any turn.
  const std::vector<Action>& next(const sim::StateSpans& state) {
    for (std::size_t i = 0; i < actions_.size(); ++i) {
      const Draw& draw = draws_[at_++ % draws_.size()];
      const std::uint64_t index = (draw.place * state.navigable_count[i]) >> 32U;
      actions_[i] = {static_cast<std::uint32_t>(index), draw.right, draw.up};
    }
    return actions_;
  }

 private:
  struct Draw {
    std::uint64_t place;  // 32 bits
    Radians right, up;
  };
  std::vector<Draw> draws_ = std::vector<Draw>(4099);  // prime: no agent sees a short cycle
  std::vector<Action> actions_;
  std::size_t at_ = 0;
};

SimulatorConfig config_of(const benchmark::State& state) {
  SimulatorConfig config = SimulatorConfig::room_to_room();
  config.batch_size = static_cast<std::size_t>(state.range(0));
  config.viewing = state.range(1) == 1 ? sim::Viewing::kDiscretized : sim::Viewing::kContinuous;
  config.navigation =
      state.range(2) == 1 ? sim::Navigation::kUnrestricted : sim::Navigation::kRestricted;
  config.threads = static_cast<int>(state.range(4));
  return config;
}

void step(benchmark::State& state) {
  const SimulatorConfig config = config_of(state);
  const auto graphs = real_graphs();
  Simulator simulator(graphs, config);
  sim::StateBuffer buffer(config.batch_size, config.max_navigable);
  const sim::StateSpans out = buffer.spans();
  std::vector<ScanIndex> scans;
  for (std::size_t i = 0; i < config.batch_size; ++i) {
    scans.emplace_back(i % static_cast<std::size_t>(state.range(3)));
  }
  simulator.new_random_episodes(scans, out);
  Walk walk(config.batch_size);
  std::uint64_t neighbours = 0;
  for (auto _ : state) {
    simulator.step(walk.next(out), out);
    neighbours += out.navigable_count[0] - 1;
  }
  const auto steps = state.iterations() * state.range(0);
  state.SetItemsProcessed(steps);
  state.counters["neighbours"] =
      static_cast<double>(neighbours) / static_cast<double>(state.iterations());
}

void construct_1000(benchmark::State& state) {
  const auto graphs = real_graphs();
  const ScanIndex scan(0);
  for (auto _ : state) {
    std::vector<Simulator> simulators;
    for (int i = 0; i < 1000; ++i) simulators.emplace_back(graphs, SimulatorConfig::room_to_room());
    sim::StateBuffer buffer(1, 32);
    for (Simulator& simulator : simulators) {
      simulator.new_random_episodes({&scan, 1}, buffer.spans());
    }
    benchmark::DoNotOptimize(simulators.data());
  }
  state.SetItemsProcessed(state.iterations() * 1000);
}

void register_all() {
  const std::vector<std::string> names{"batch", "discretized", "unrestricted", "scans", "threads"};
  const auto all = static_cast<std::int64_t>(real_graphs()->size());
  // One thread: its own time, which other programs on the machine disturb little.
  auto* one = benchmark::RegisterBenchmark("step", step)->ArgNames(names);
  for (const std::int64_t unrestricted : {0, 1}) {
    for (const std::int64_t discretized : {1, 0}) {
      for (const std::int64_t scans : {std::int64_t{1}, all}) {
        one->Args({100, discretized, unrestricted, scans, 1});
      }
    }
  }
  for (const std::int64_t batch : {1, 10, 1000}) one->Args({batch, 1, 0, all, 1});
  // Several: the time on the wall.
  auto* more = benchmark::RegisterBenchmark("step_threads", step)->ArgNames(names)->UseRealTime();
  for (const std::int64_t batch : {1000, 4000, 64000}) {
    for (const std::int64_t threads : {1, 2}) more->Args({batch, 0, 1, all, threads});
  }
  benchmark::RegisterBenchmark("construct_1000", construct_1000)->Unit(benchmark::kMillisecond);
}

}  // namespace
}  // namespace enfilade

int main(int argc, char** argv) { return enfilade::bench::run(argc, argv, enfilade::register_all); }
