/// \file  The work of a collection as files that the rest of Enfilade reads.
#pragma once
#include <string>

#include "enfilade/service/collecting/tasks.h"

namespace enfilade::service::collecting {

/// Annotations in Room-to-Room's format, as `enfilade stats` and `enfilade score` read them.
/// kWrite: the paths that have an instruction, with their instructions in the order in which the
/// tasks were given out. kWalk: the paths whose every instruction was walked.
std::string annotations_json(store::Database& db, const ExportedSplit& exported);

/// Results as `enfilade score` takes them, of the first walk of each instruction. Only of paths
/// whose every instruction was walked: the same episodes as in annotations_json().
/// \pre it is a collection of walks
std::string results_json(store::Database& db, const ExportedSplit& exported);

/// The same walks, an object each: instr_id, scan, worker, submitted, seconds, camera, steps.
/// \pre it is a collection of walks
std::string walks_json(store::Database& db, const ExportedSplit& exported);

}  // namespace enfilade::service::collecting
