/// \file  `--task`: which benchmark a verb is about.
#pragma once
#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/dataset/dataset.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/results.h"

namespace enfilade::apps {

/// Whether a verb has the continuous benchmarks too.
enum class FreeTasks : std::uint8_t { kNot, kToo };

/// Adds `--task NAME`; `otherwise` describes the default.
void add_task_option(CLI::App& verb, std::string& task, const std::string& otherwise,
                     FreeTasks free = FreeTasks::kNot);

/// The benchmark of that option. If it is empty, `found`, or R2R if the data set has a split of it.
/// Else the data set's only benchmark.
/// \throws LookupError for an unknown name; UsageError if the data set has several others
tasks::Task task_of(const std::string& named, const dataset::Dataset& data,
                    std::optional<tasks::Task> found = {});

/// The benchmark of some results, in either world. The option's, if it names one. Else the one that
/// the results show; if they show none, as task_of().
/// \throws LookupError for an unknown name; as task_of(), report::find_benchmark_of_runs()
const tasks::Benchmark& benchmark_of_runs(const std::string& named, const dataset::Dataset& data,
                                          std::span<const std::filesystem::path> results);

/// A split of any benchmark. \throws as dataset::Dataset::episodes()
tasks::EpisodeSet episodes_of(const dataset::Dataset& data, tasks::Task task,
                              const std::string& split,
                              tasks::Instructions instructions = tasks::Instructions::kScored);

/// Prints the scores of results to stdout. R2R has our own table, others the measures of the public
/// code behind the published tables.
/// \pre the goals are not hidden
void print_score(const std::vector<tasks::Trajectory>& trajectories,
                 const tasks::EpisodeSet& episodes);

}  // namespace enfilade::apps
