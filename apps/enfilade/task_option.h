/// \file  `--task`: which benchmark a verb is about; running an agent over a split of it.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <string>

#include "enfilade/agents/run.h"
#include "enfilade/continuous/buildings.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/split.h"

namespace enfilade::apps {

/// Which benchmarks a verb has.
enum class Worlds : std::uint8_t { kGraph, kBoth };

/// Adds `--task NAME`; `otherwise` describes the default.
void add_task_option(CLI::App& verb, std::string& task, const std::string& otherwise,
                     Worlds worlds = Worlds::kGraph);

/// The benchmark of that option. If it is empty, `found`, or R2R if the data set has a split of it.
/// Else the data set's only benchmark on graphs.
/// \throws LookupError for an unknown name; UsageError if the data set has several others
const tasks::Benchmark& benchmark_of(const std::string& named, const dataset::Dataset& data,
                                     const tasks::Benchmark* found = nullptr);
/// The same of a verb that has benchmarks on graphs alone. \throws also LookupError for another
tasks::Task task_of(const std::string& named, const dataset::Dataset& data);

/// Prints the scores of results to stdout. R2R has our own table, others the measures of the public
/// code behind the published tables. \param buildings  agents::open_buildings()
/// \pre the goals are not hidden
void print_score(const tasks::Trajectories& trajectories, const tasks::Split& split,
                 const continuous::Buildings* buildings);

/// Options of `run`.
struct AgentRun {
  std::string data = {}, features = {}, meshes = {}, output = {};
  std::string agent = "random", split = "val_unseen", task = {}, form = {};
  /// Continuous: a graph agent decides, and its trajectories are followed.
  bool walk_graph = false;
  agents::RunOptions run = {};
  int threads = 0;  ///< of rendering for a trained continuous agent, 0: all cores
};
/// Runs an agent, writes its results and prints their scores.
/// \throws UsageError for options that do not go together; errors of files
void run_agent_over_split(const AgentRun& options);

}  // namespace enfilade::apps
