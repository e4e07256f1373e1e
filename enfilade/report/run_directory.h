/// \file  What agents left behind: results files, model directories, their logs.
#pragma once
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/dataset/dataset.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/goal.h"

namespace enfilade::report {

/// A results file and what its name says about it.
struct ResultsFile {
  std::filesystem::path file;
  std::string agent;  ///< "random", "student-2"
  std::string split;  ///< "val_unseen"
};

/// What training made: config.json, log.jsonl, results/.
struct ModelDirectory {
  std::filesystem::path folder;
  std::string agent;  ///< the folder's name: "student-2"
};

/// What was found in the folder of a run.
struct RunDirectory {
  std::vector<ResultsFile> results;      ///< shortest, reference, random, teacher, student, others
  std::vector<ModelDirectory> models;    ///< likewise
  tasks::Task task = tasks::Task::kR2r;  ///< what all results are of
};

/// "student-2" and "student" are runs of one agent, with different seeds: the name without them.
std::string_view without_seed(std::string_view agent) noexcept;

/// Whether an agent knows the goal: "shortest", "reference".
bool is_oracle(std::string_view agent) noexcept;

/// Which benchmark the results are of that are named or lie in the named folders, by the fields
/// that only its results have. No value if the first of them could be of several, or if there is
/// none. \throws FileError for what is not there or cannot be read
std::optional<tasks::Task> find_task_of_runs(std::span<const std::filesystem::path> named);

/// What is named: a results file "<agent>_<split>.json"; a model directory (a folder with
/// config.json), whose results are "results/<split>.json"; or a folder with any of these, in
/// itself, in results/ and in models/. A split is what `data` has annotations of, of that
/// benchmark. A file of another name is passed over where a folder was named, and one of walks in
/// continuous space. \throws FileError for
/// what is not there; LookupError for a file whose name says no split of `data`, for one agent and
/// split in two files, or where there is nothing at all
RunDirectory find_runs(std::span<const std::filesystem::path> named, const dataset::Dataset& data,
                       tasks::Task task = tasks::Task::kR2r);

/// The same of walks in continuous space, whose splits are those of VLN-CE's files in the folder of
/// `data`. In a folder, results of the graph are passed over, as find_runs() does with these.
/// \throws as find_runs()
RunDirectory find_continuous_runs(std::span<const std::filesystem::path> named,
                                  const dataset::Dataset& data, const tasks::Benchmark& benchmark);
/// The benchmark of walks in continuous space whose results are named or lie in the named folders,
/// by their first record; none if results of the graph come first. \throws as find_task_of_runs()
const tasks::Benchmark* find_continuous_benchmark_of_runs(
    std::span<const std::filesystem::path> named);

}  // namespace enfilade::report
