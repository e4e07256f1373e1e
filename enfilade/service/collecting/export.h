/// \file  The work of a collection as files that the rest of Enfilade reads.
#pragma once
#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/service/collecting/assignments.h"

namespace enfilade::service::collecting {

/// Counts of an export of trajectories or instructions, and of the work that it leaves out.
/// Practice is in neither.
struct ExportReport {
  std::string split;
  WorkKind kind = WorkKind::kWrite;
  std::string language = {};          ///< kGuide
  std::int64_t items = 0, paths = 0;  ///< of the split
  std::int64_t exported_items = 0, exported_paths = 0, exported_tasks = 0;
  // Submitted tasks that are left out, each counted once:
  std::int64_t waiting = 0;  ///< not reviewed yet, if only accepted ones were requested
  std::int64_t rejected = 0;
  std::int64_t repeated = 0;  ///< a later trajectory of an instruction that has one
  /// Trajectories of a path some of whose instructions have none; dialogues without the other's
  /// task.
  std::int64_t incomplete = 0;

  std::int64_t left_out() const { return waiting + rejected + repeated + incomplete; }
  /// "6 of 8 instructions; 2 walks left out: 1 waiting for review, 1 rejected"
  std::string summary() const;
};
nlohmann::ordered_json report_json(const ExportReport& report);

/// The work in a file of a split.
struct Selection {
  std::vector<Assignment> tasks;  ///< sorted by item and task
  ExportReport report;
  bool secret = false;  ///< some goals of the split are
};
/// Of trajectories, the first per instruction, and only of paths whose instructions all have one.
Selection select_work(store::Database& db, const ExportedSplit& exported);

// Those of a Selection \throw Refusal kConflict if it has no task; the message is the report's
// summary().

/// Annotations, as `enfilade stats` and `enfilade score` read them.
/// - kWrite: the paths that have an instruction, with their instructions in the order of the tasks;
///   Room-to-Room's format
/// - kWalk: the paths with a trajectory for every instruction; Room-to-Room's format
/// - kDescribe, kFind: the same for objects, in REVERIE's format
/// - kGuide: lines of RxR's guides, whose instruction_id is the task's number
/// - kDialogue: instances of CVDN's navigation from dialogue history, of dialogues whose tasks are
///   both in the selection
std::string annotations_json(const Selection& selection, const graph::GraphSet& graphs);

/// The dialogues of a Selection, an object each: dialogue, scan, target, end_panos, workers by
/// role, turns. \pre it is of dialogues
std::string dialogues_json(const Selection& selection);

/// Results as `enfilade score` takes them: the same episodes as in annotations_json().
/// \pre it is of trajectories
std::string results_json(const Selection& selection);

/// The same trajectories, one object each: instr_id, scan, worker, times (add_times()), camera,
/// steps. A guide's steps are its pose trace; instr_id is that of its instruction.
/// \pre it is of trajectories or of guides
std::string walks_json(const Selection& selection);

/// The pose traces of guides as RxR's, a zip file of `<id>_guide_pose_trace.npz`, where id is the
/// instruction's. Fields that the page does not record are those of MatterSim's usual view: 60
/// degrees high, 4 to 3.
/// \pre it is of guides
std::string traces_zip(const Selection& selection, const graph::GraphSet& graphs);

/// All submitted tasks of the split in any state, one object each: task, state, path_id, number,
/// worker, times, flags. Work that other files leave out can be looked up in it.
std::string tasks_json(store::Database& db, const ExportedSplit& exported);

}  // namespace enfilade::service::collecting
