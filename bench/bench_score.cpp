// Scoring the trajectories of a whole data set: for all splits with known goals, the reference path
// with turns on the spot, repeated to 21,567 (R2R's scored instructions). The graphs are open; what
// is timed is score_trajectories(), with and without making the all-pairs distances.
#include <benchmark/benchmark.h>

#include <cstdint>
#include <memory>
#include <vector>

#include "bench/main.h"
#include "enfilade/core/rng.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade {
namespace {

constexpr std::size_t kTrajectories = 21567;

struct Work {
  tasks::EpisodeSet episodes;
  std::vector<tasks::Trajectory> trajectories;
};

// The splits as one, so that one call scores all of them.
tasks::EpisodeSet known_goals() {
  const auto data = *scan::DataRoot::from_environment();
  tasks::EpisodeSet all{"all", graph::GraphSet::open(data.connectivity()), {}, {}};
  for (const char* split : {"train", "val_seen", "val_unseen"}) {
    tasks::EpisodeSet one =
        make_episodes(tasks::load_annotations(data.annotations(split), split), all.graphs);
    for (tasks::Episode& episode : one.episodes) {
      episode.path += all.paths.size();
      all.episodes.push_back(std::move(episode));
    }
    all.paths.insert(all.paths.end(), one.paths.begin(), one.paths.end());
  }
  return all;
}

// Up to three turns before each step, as agents with 30-degree views make them.
Work make_work() {
  Work work{known_goals(), {}};
  Rng rng(1);
  for (std::size_t i = 0; i < kTrajectories; ++i) {
    tasks::Trajectory& trajectory = work.trajectories.emplace_back();
    trajectory.episode = i % work.episodes.episodes.size();
    for (const auto v :
         work.episodes.path_of(work.episodes.episodes[trajectory.episode]).viewpoints) {
      trajectory.points.insert(trajectory.points.end(), 1 + rng.below(4), {v, {}, {}});
    }
  }
  return work;
}

std::size_t points(const Work& work) {
  std::size_t sum = 0;
  for (const auto& trajectory : work.trajectories) sum += trajectory.points.size();
  return sum;
}

void report(benchmark::State& state, const Work& work) {
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(kTrajectories));
  state.counters["points"] = static_cast<double>(points(work)) / static_cast<double>(kTrajectories);
}

// Threads as the argument says; distances are there.
void score(benchmark::State& state) {
  static const Work kWork = make_work();
  const auto run = [&] {
    return tasks::score_trajectories(kWork.trajectories, kWork.episodes, {},
                                     static_cast<int>(state.range(0)));
  };
  benchmark::DoNotOptimize(run());
  for (auto _ : state) benchmark::DoNotOptimize(run());
  report(state, kWork);
}

// The first time in a process: all-pairs distances of the 72 buildings are made on the way.
void score_first(benchmark::State& state) {
  Work work = make_work();
  const auto data = *scan::DataRoot::from_environment();
  for (auto _ : state) {
    state.PauseTiming();
    work.episodes.graphs = graph::GraphSet::open(data.connectivity());
    work.episodes.graphs->load_all();
    state.ResumeTiming();
    benchmark::DoNotOptimize(tasks::score_trajectories(work.trajectories, work.episodes, {},
                                                       static_cast<int>(state.range(0))));
  }
  report(state, work);
}

// Metrics, and the means with 1,000 bootstrap samples.
void score_with_intervals(benchmark::State& state) {
  static const Work kWork = [] {
    Work work = make_work();
    work.trajectories.resize(work.episodes.episodes.size());
    return work;
  }();
  tasks::ScoreOptions options;
  options.threads = static_cast<int>(state.range(0));
  for (auto _ : state) {
    benchmark::DoNotOptimize(compute_score(kWork.trajectories, kWork.episodes, options));
  }
  state.SetItemsProcessed(state.iterations() *
                          static_cast<std::int64_t>(kWork.trajectories.size()));
}

// Reading and checking the results file that these trajectories make.
void read_results(benchmark::State& state) {
  Work work = make_work();
  work.trajectories.resize(work.episodes.episodes.size());
  const std::string text = to_json(work.trajectories, work.episodes);
  for (auto _ : state) {
    benchmark::DoNotOptimize(tasks::parse_results(text, "<memory>", work.episodes));
  }
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(text.size()));
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(work.trajectories.size()));
}

void register_on_threads(const char* name, void (*function)(benchmark::State&)) {
  benchmark::RegisterBenchmark(name, function)
      ->ArgName("threads")
      ->Arg(1)
      ->Arg(2)
      ->Unit(benchmark::kMillisecond)
      ->UseRealTime();
}

void register_all() {
  register_on_threads("score", score);
  register_on_threads("score_first", score_first);
  register_on_threads("score_with_intervals", score_with_intervals);
  benchmark::RegisterBenchmark("read_results", read_results)->Unit(benchmark::kMillisecond);
}

}  // namespace
}  // namespace enfilade

int main(int argc, char** argv) { return enfilade::bench::run(argc, argv, enfilade::register_all); }
