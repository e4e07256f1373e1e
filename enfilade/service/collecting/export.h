/// \file  A collection's work as files that the rest of Enfilade reads.
#pragma once
#include <string>

#include "enfilade/service/collecting/tasks.h"

namespace enfilade::service::collecting {

/// kWrite: R2R annotations of the paths that have an instruction, their instructions in the order
/// in which the tasks were given out. kWalk: those of the paths whose every instruction was walked.
/// Both as `enfilade stats` and `enfilade score` read them.
std::string annotations_json(store::Database& db, const Collection& collection,
                             const std::string& split, Reviewed reviewed);

/// kWalk: results as `enfilade score` takes them, of the first walk of each instruction. Only of
/// paths whose every instruction was walked: the same episodes as in annotations_json(). \pre
/// collection.kind is kWalk
std::string results_json(store::Database& db, const Collection& collection,
                         const std::string& split, Reviewed reviewed);

/// The same walks, an object each: instr_id, worker, submitted, seconds, camera, steps.
std::string walks_json(store::Database& db, const Collection& collection, const std::string& split,
                       Reviewed reviewed);

}  // namespace enfilade::service::collecting
