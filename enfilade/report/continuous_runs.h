/// \file  Results files of continuous trajectories, with their scores.
#pragma once
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/agents/continuous_benchmark.h"
#include "enfilade/continuous/buildings.h"
#include "enfilade/core/progress.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/report/run_directory.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/continuous_measures.h"
#include "enfilade/tasks/continuous_results.h"

namespace enfilade::report {

/// One agent (with one seed) on one split.
struct ContinuousRun {
  std::string agent;  ///< "random-2"
  std::string split;
  std::vector<tasks::ContinuousResult> walks;  ///< in the order of the split's episodes
  std::vector<tasks::ContinuousScore> scores;  ///< per trajectory
  tasks::ContinuousMeasures measures;
};

/// A plain value: any thread.
struct ContinuousRuns {
  agents::ContinuousBenchmark benchmark;
  std::shared_ptr<const continuous::Buildings> buildings;
  std::map<std::string, tasks::ContinuousEpisodes> splits;  ///< those that a run has
  std::vector<ContinuousRun> runs;                          ///< in the order of the results files
  std::vector<std::string> left_out;  ///< a sentence for each file that could not be scored
};

/// Reads and scores every results file, with bootstrap intervals. Files of splits with hidden goals
/// are listed in `left_out` instead.
/// \param found  by find_continuous_runs()
/// \throws FileError, also for missing navigation meshes; InvalidInput listing the faults of a
/// results file
ContinuousRuns score_continuous_runs(const RunDirectory& found,
                                     const agents::ContinuousBenchmark& benchmark,
                                     const dataset::Dataset& data, const Progress& progress = {});

}  // namespace enfilade::report
