/// \file  Results files of walks in continuous space, scored.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/continuous/buildings.h"
#include "enfilade/core/progress.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/report/run_directory.h"
#include "enfilade/tasks/benchmark.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::report {

/// One agent (with one seed) on one split.
struct ContinuousRun {
  std::string agent;  ///< "random-2"
  std::string split;
  std::vector<tasks::ContinuousResult> walks;  ///< in the order of the split's episodes
  tasks::ScoreTable scores;                    ///< by the default scorer, a row per walk
};

/// A plain value: any thread.
struct ContinuousRuns {
  const tasks::Benchmark* benchmark = nullptr;
  std::shared_ptr<const continuous::Buildings> buildings;
  std::map<std::string, tasks::ContinuousEpisodes> splits;  ///< those that a run has
  std::vector<ContinuousRun> runs;                          ///< in the order of the results files
  std::vector<std::string> left_out;  ///< a sentence for each file that could not be scored
};

/// Reads and scores every results file, with bootstrap intervals. Those of splits whose goals are
/// hidden are left out, and `left_out` says so. \param found  by find_continuous_runs()
/// \throws FileError, also for navigation meshes that are not there; InvalidInput listing what is
/// wrong with a results file
ContinuousRuns score_continuous_runs(const RunDirectory& found, const tasks::Benchmark& benchmark,
                                     const dataset::Dataset& data, const Progress& progress = {});

}  // namespace enfilade::report
