/// \file  Files of runs: results files, model directories, their logs.
#pragma once
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/agents/continuous_benchmark.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/tasks/goal.h"

namespace enfilade::report {

/// A results file and the parts of its name.
struct ResultsFile {
  std::filesystem::path file;
  std::string agent;  ///< "random", "student-2"
  std::string split;  ///< "val_unseen"
};

/// Files of a training: config.json, log.jsonl, results/.
struct ModelDirectory {
  std::filesystem::path folder;
  std::string agent;  ///< the folder's name: "student-2"
};

/// The files found in the folder of a run.
struct RunDirectory {
  std::vector<ResultsFile> results;      ///< shortest, reference, random, teacher, student, others
  std::vector<ModelDirectory> models;    ///< likewise
  tasks::Task task = tasks::Task::kR2r;  ///< benchmark of all results
};

/// "student-2" and "student" are runs of one agent, with different seeds: the name without them.
std::string_view without_seed(std::string_view agent) noexcept;

/// Whether an agent uses the goal: "shortest", "reference".
bool is_oracle(std::string_view agent) noexcept;

/// The benchmark of the results that are named or lie in the named folders, by the fields that only
/// its results have. No value if the first of them could be of several, or if there is none.
/// \throws FileError for files that are missing or cannot be read
std::optional<tasks::Task> find_task_of_runs(std::span<const std::filesystem::path> named);

/// The runs of the named files and folders. Each is one of:
/// - a results file "<agent>_<split>.json"
/// - a model directory (a folder with config.json), whose results are "results/<split>.json"
/// - a folder with any of these, in itself, in results/ and in models/
///
/// A split is one of that benchmark with annotations in `data`. In a folder, files of other names
/// and continuous results are skipped.
/// \throws FileError for missing files
/// \throws LookupError for a file whose name has no split of `data`, for one agent and split in two
/// files, or for no results
RunDirectory find_runs(std::span<const std::filesystem::path> named, const dataset::Dataset& data,
                       tasks::Task task = tasks::Task::kR2r);

/// The same for continuous trajectories, whose splits are those of VLN-CE's files in the folder of
/// `data`. In a folder, results of the graph are skipped.
/// \throws as find_runs()
RunDirectory find_continuous_runs(std::span<const std::filesystem::path> named,
                                  const dataset::Dataset& data,
                                  const agents::ContinuousBenchmark& benchmark);
/// The benchmark of the named continuous results, or of those in the named folders, by their first
/// record. Null if results of the graph come first.
/// \throws FileError for files that are missing or cannot be read
const agents::ContinuousBenchmark* find_continuous_benchmark_of_runs(
    std::span<const std::filesystem::path> named);

}  // namespace enfilade::report
