#include "apps/enfilade/task_option.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string_view>
#include <vector>

#include "apps/common/program.h"
#include "enfilade/report/run_directory.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/files.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::apps {

void add_task_option(CLI::App& verb, std::string& task, const std::string& otherwise,
                     FreeTasks free) {
  add_value(
      verb, "--task", task, "NAME",
      fmt::format("r2r, r2r-last, r2r-back, r4r, rxr, reverie, cvdn{} (default: {})",
                  free == FreeTasks::kToo ? ", soon, r2r-ce or rxr-ce" : " or soon", otherwise));
}

tasks::Task task_of(const std::string& named, const dataset::Dataset& data,
                    std::optional<tasks::Task> found) {
  if (!named.empty()) return tasks::benchmark(named, tasks::World::kGraph).task;
  if (found) return *found;
  const std::vector<tasks::Task> there = data.benchmarks();
  // Without any, the verb says which files of R2R it did not find.
  if (there.empty() || there.front() == tasks::Task::kR2r) return tasks::Task::kR2r;
  if (there.size() == 1) return there.front();
  std::vector<std::string_view> names;
  for (const tasks::Task task : there) names.push_back(tasks::benchmark(task).name);
  throw UsageError(fmt::format("{} has annotations of {}: which ones? Give --task NAME",
                               data.folder().string(), fmt::join(names, ", ")));
}

const tasks::Benchmark& benchmark_of_runs(const std::string& named, const dataset::Dataset& data,
                                          std::span<const std::filesystem::path> results) {
  if (!named.empty()) return tasks::benchmark(named);
  if (const tasks::Benchmark* found = report::find_benchmark_of_runs(results)) return *found;
  return tasks::benchmark(task_of(named, data));
}

tasks::EpisodeSet episodes_of(const dataset::Dataset& data, tasks::Task task,
                              const std::string& split, tasks::Instructions instructions) {
  return task == tasks::Task::kR2r ? data.episodes(split, instructions)
                                   : data.episodes(task, split, instructions);
}

void print_score(const std::vector<tasks::Trajectory>& trajectories,
                 const tasks::EpisodeSet& episodes) {
  const tasks::Benchmark& benchmark = tasks::benchmark(episodes.task);
  const auto& scorer = benchmark.scorer(benchmark.table_scorer);
  fmt::print("{}", to_table(compute_score(trajectories, episodes, scorer)));
}

}  // namespace enfilade::apps
