/// \file  Results files, scored.
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/report/run_directory.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score.h"
#include "enfilade/tasks/task_score.h"

namespace enfilade::report {

/// The scores of a split's episodes.
struct Scores {
  /// Per episode, by tasks/metrics.h. If the goal is not to end near the path's last viewpoint,
  /// some fields refer to the actual goal (tasks/goal_distance.h), without answers except
  /// R2R-Back's. These are `success`, `nav_error`, `oracle_success`, `oracle_error`, `shortest` and
  /// `spl`.
  tasks::Score ours;
  /// By table_scorer(); no value for R2R.
  std::optional<tasks::TaskScore> by_task;
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

/// Reads and scores every results file, with bootstrap intervals. Files of splits with hidden goals
/// are listed in `left_out` instead. The benchmark is that of `found`.
/// \throws FileError; InvalidInput listing the faults of a results file
ScoredRuns score_runs(const RunDirectory& found, const dataset::Dataset& data,
                      const Progress& progress = {});

}  // namespace enfilade::report
