/// \file  What agents left behind: results files, model directories, their logs. Results files of
/// either world, scored.
#pragma once
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/continuous/buildings.h"
#include "enfilade/core/progress.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/goal.h"
#include "enfilade/tasks/score_table.h"
#include "enfilade/tasks/split.h"

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
  std::vector<ResultsFile> results;    ///< shortest, reference, random, teacher, student, others
  std::vector<ModelDirectory> models;  ///< likewise
  const tasks::Benchmark* benchmark = nullptr;  ///< what all results are of
};

/// "student-2" and "student" are runs of one agent, with different seeds: the name without them.
std::string_view without_seed(std::string_view agent) noexcept;

/// Whether an agent knows the goal: "shortest", "reference".
bool is_oracle(std::string_view agent) noexcept;

/// Which benchmark the results are of that are named or lie in the named folders, by the fields
/// that only its results have. Null if the first of them could be of several, or if there is none.
/// \throws FileError for what is not there or cannot be read
const tasks::Benchmark* find_benchmark_of_runs(std::span<const std::filesystem::path> named);

/// Finds the results and models of the named paths. Each path is one of these:
/// - a results file "<agent>_<split>.json"
/// - a model directory (a folder with config.json), whose results are "results/<split>.json"
/// - a folder with any of these, in itself, in results/ and in models/
///
/// A split is one that `data` has annotations of, for that benchmark. In a named folder, files with
/// other names and results of the other world are skipped.
/// \throws FileError for a missing path
/// \throws LookupError for a named file whose name has no split of `data`, for one agent and split
/// in two files, or if nothing was found
RunDirectory find_runs(std::span<const std::filesystem::path> named, const dataset::Dataset& data,
                       const tasks::Benchmark& benchmark = tasks::benchmark(tasks::Task::kR2r));

/// What the episodes of a split are worth.
struct RunScores {
  tasks::ScoreTable ours;  ///< graph: by own_scorer(); continuous: by the default scorer
  std::optional<tasks::ScoreTable> by_task = {};  ///< by Benchmark::table_scorer, where it has one
};

/// One agent (with one seed) on one split.
struct ScoredRun {
  std::string agent;  ///< "student-2"
  std::string split;
  tasks::Trajectories trajectories = {};  ///< in the order of the split's episodes
  RunScores scores = {};
  std::map<std::string, RunScores> languages = {};  ///< of RxR, of the episodes in each of them
};

/// A plain value: any thread.
struct ScoredRuns {
  const tasks::Benchmark* benchmark = nullptr;
  std::shared_ptr<const graph::GraphSet> graphs;           ///< graph only
  std::shared_ptr<const continuous::Buildings> buildings;  ///< continuous only
  std::map<std::string, tasks::Split> splits;              ///< those that a run has
  std::vector<ScoredRun> runs;        ///< in the order of RunDirectory::results
  std::vector<std::string> left_out;  ///< a sentence for each file that could not be scored

  /// \pre run is one of `runs`
  const tasks::Split& split_of(const ScoredRun& run) const { return splits.at(run.split); }
};

/// Reads and scores every results file, with bootstrap intervals. Those of splits whose goals are
/// hidden are left out, and `left_out` says so. The benchmark is that of `found`.
/// \throws FileError, also for navigation meshes that are not there; InvalidInput listing what is
/// wrong with a results file
ScoredRuns score_runs(const RunDirectory& found, const dataset::Dataset& data,
                      const Progress& progress = {});

}  // namespace enfilade::report
