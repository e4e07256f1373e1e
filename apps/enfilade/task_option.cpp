#include "apps/enfilade/task_option.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <string_view>
#include <vector>

#include "apps/common/program.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::apps {

void add_task_option(CLI::App& verb, std::string& task, const std::string& otherwise,
                     Worlds worlds) {
  add_value(
      verb, "--task", task, "NAME",
      fmt::format("r2r, r2r-last, r2r-back, r4r, rxr, reverie, cvdn{} (default: {})",
                  worlds == Worlds::kBoth ? ", soon, r2r-ce or rxr-ce" : " or soon", otherwise));
}

const tasks::Benchmark& benchmark_of(const std::string& named, const dataset::Dataset& data,
                                     const tasks::Benchmark* found) {
  if (!named.empty()) return tasks::benchmark(named);
  if (found != nullptr) return *found;
  std::vector<const tasks::Benchmark*> there = data.benchmarks();
  std::erase_if(there, &tasks::Benchmark::continuous);
  // Without any, the verb says which files of R2R it did not find.
  if (there.empty() || there.front()->task == tasks::Task::kR2r) {
    return tasks::benchmark(tasks::Task::kR2r);
  }
  if (there.size() == 1) return *there.front();
  std::vector<std::string_view> names;
  for (const tasks::Benchmark* one : there) names.push_back(one->name);
  throw UsageError(fmt::format("{} has annotations of {}: which ones? Give --task NAME",
                               data.folder().string(), fmt::join(names, ", ")));
}

tasks::Task task_of(const std::string& named, const dataset::Dataset& data) {
  if (!named.empty()) return tasks::benchmark(named, tasks::WorldKind::kGraph).task;
  return benchmark_of(named, data).task;
}

void print_score(const tasks::Trajectories& trajectories, const tasks::Split& split,
                 const continuous::Buildings* buildings) {
  const tasks::Benchmark& benchmark = split.benchmark();
  say("{}", to_table(agents::compute_score(trajectories, split, buildings,
                                           benchmark.scorer(benchmark.table_scorer),
                                           progress_bar("scoring"))));
}

}  // namespace enfilade::apps
