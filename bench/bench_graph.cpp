// Opening navigation graphs, all-pairs shortest paths, and the viewpoint nearest to a point.
#include <benchmark/benchmark.h>

#include <filesystem>
#include <memory>
#include <vector>

#include "bench/main.h"
#include "enfilade/core/rng.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/data_root.h"

namespace enfilade {
namespace {

using graph::GraphSet;
using graph::NavGraph;

std::filesystem::path folder() { return scan::DataRoot::from_environment()->connectivity(); }

// The graph of the middle size, and the largest.
void open_one(benchmark::State& state, const char* scan) {
  for (auto _ : state) {
    const auto graphs = GraphSet::open(folder());
    benchmark::DoNotOptimize(graphs->graph(scan).size());
  }
}

void open_all(benchmark::State& state) {
  std::size_t opened = 0;
  for (auto _ : state) {
    const auto graphs = GraphSet::open(folder());
    graphs->load_all(static_cast<int>(state.range(0)));
    opened += graphs->size();
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(opened));
}

void all_pairs(benchmark::State& state) {
  std::size_t done = 0;
  for (auto _ : state) {
    state.PauseTiming();  // paths are computed once in a graph's life
    const auto graphs = GraphSet::open(folder());
    graphs->load_all();
    state.ResumeTiming();
    for (std::size_t i = 0; i < graphs->size(); ++i) {
      const ViewpointIndex first(0);
      benchmark::DoNotOptimize(graphs->graph(ScanIndex(i)).distance(first, first));
    }
    done += graphs->size();
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(done));
}

void nearest(benchmark::State& state, const char* scan) {
  const auto graphs = GraphSet::open(folder());
  const NavGraph& graph = graphs->graph(scan);
  Rng rng(1);
  std::vector<Vec3f> points;
  for (int i = 0; i < 1000; ++i) {
    Vec3f p = graph.position(ViewpointIndex(rng.below(graph.size())));
    p.x += static_cast<float>(rng.uniform() * 2 - 1);
    p.y += static_cast<float>(rng.uniform() * 2 - 1);
    points.push_back(p);
  }
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(graph.nearest(points[i++ % points.size()]));
  state.SetItemsProcessed(state.iterations());
}

void register_all() {
  constexpr const char* kTypical = "XcA2TqTSSAj";
  constexpr const char* kLargest = "B6ByNegPMKs";
  for (const char* scan : {kTypical, kLargest}) {
    const std::string suffix = std::string("/") + scan;
    benchmark::RegisterBenchmark(("open_one" + suffix).c_str(), open_one, scan)
        ->Unit(benchmark::kMillisecond);
    benchmark::RegisterBenchmark(("nearest" + suffix).c_str(), nearest, scan);
  }
  benchmark::RegisterBenchmark("open_all", open_all)
      ->ArgName("threads")
      ->Arg(1)
      ->Arg(2)
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
  benchmark::RegisterBenchmark("all_pairs", all_pairs)->Unit(benchmark::kMillisecond);
}

}  // namespace
}  // namespace enfilade

int main(int argc, char** argv) { return enfilade::bench::run(argc, argv, enfilade::register_all); }
