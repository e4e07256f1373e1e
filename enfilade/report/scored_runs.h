/// \file  Results files, scored.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/report/run_directory.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::report {

/// What the episodes of a split are worth.
struct Scores {
  tasks::ScoreTable ours;     ///< by own_scorer()
  tasks::ScoreTable by_task;  ///< by Benchmark::table_scorer
};

/// One agent (with one seed) on one split.
struct ScoredRun {
  std::string agent;  ///< "student-2"
  std::string split;
  std::vector<tasks::Trajectory> trajectories;  ///< in the order of the split's episodes
  Scores scores;
  std::map<std::string, Scores> languages = {};  ///< of RxR, of the episodes in each of them
};

/// A plain value: any thread.
struct ScoredRuns {
  tasks::Task task = tasks::Task::kR2r;
  std::shared_ptr<const graph::GraphSet> graphs;
  std::map<std::string, tasks::EpisodeSet> splits;  ///< those that a run has
  std::vector<ScoredRun> runs;                      ///< in the order of RunDirectory::results
  std::vector<std::string> left_out;  ///< a sentence for each file that could not be scored
};

/// Reads and scores every results file, with bootstrap intervals. Those of splits whose goals are
/// hidden are left out, and `left_out` says so. The benchmark is that of `found`.
/// \throws FileError; InvalidInput listing what is wrong with a results file
ScoredRuns score_runs(const RunDirectory& found, const dataset::Dataset& data,
                      const Progress& progress = {});

}  // namespace enfilade::report
