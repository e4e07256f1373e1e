/// \file  Results files of either world, scored.
#pragma once
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/continuous/buildings.h"
#include "enfilade/core/progress.h"
#include "enfilade/dataset/dataset.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/report/run_directory.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/continuous_results.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/score_table.h"

namespace enfilade::report {

/// What the episodes of a split are worth.
struct Scores {
  tasks::ScoreTable ours;  ///< graph: by own_scorer(); continuous: by the default scorer
  std::optional<tasks::ScoreTable> by_task = {};  ///< by Benchmark::table_scorer, where it has one
};

/// One agent (with one seed) on one split.
struct ScoredRun {
  std::string agent;  ///< "student-2"
  std::string split;
  // One of the two, in the order of the split's episodes.
  std::vector<tasks::Trajectory> trajectories = {};
  std::vector<tasks::ContinuousResult> walks = {};
  Scores scores = {};
  std::map<std::string, Scores> languages = {};  ///< of RxR, of the episodes in each of them
};

/// A plain value: any thread.
struct ScoredRuns {
  const tasks::Benchmark* benchmark = nullptr;
  std::shared_ptr<const graph::GraphSet> graphs;           ///< graph only
  std::shared_ptr<const continuous::Buildings> buildings;  ///< continuous only
  /// Those that a run has; the second in continuous space.
  std::map<std::string, tasks::EpisodeSet> splits;
  std::map<std::string, tasks::ContinuousEpisodes> continuous_splits;
  std::vector<ScoredRun> runs;        ///< in the order of RunDirectory::results
  std::vector<std::string> left_out;  ///< a sentence for each file that could not be scored
};

/// Reads and scores every results file, with bootstrap intervals. Those of splits whose goals are
/// hidden are left out, and `left_out` says so. The benchmark is that of `found`.
/// \throws FileError, also for navigation meshes that are not there; InvalidInput listing what is
/// wrong with a results file
ScoredRuns score_runs(const RunDirectory& found, const dataset::Dataset& data,
                      const Progress& progress = {});

}  // namespace enfilade::report
