/// \file  What a collection came to, as files that the rest of Enfilade reads.
#pragma once
#include <string>

#include "enfilade/service/collecting/tasks.h"

namespace enfilade::service::collecting {

/// What of the work is taken.
enum class Taken : std::uint8_t {
  kAccepted,
  kAll,  ///< what waits for review too
};

/// kWrite: R2R annotations of the paths that have an instruction, their instructions in the order
/// in which the tasks were given out. kWalk: those of the paths whose every instruction was walked.
/// Both as `enfilade stats` and `enfilade score` read them.
std::string annotations_json(store::Database& database, const Collection& collection,
                             const std::string& split, Taken taken);

/// kWalk: results as `enfilade score` takes them, of the first walk of each instruction. Of paths
/// whose every instruction was walked only: the file is of the very episodes that
/// annotations_json() has. \pre collection.kind is kWalk
std::string results_json(store::Database& database, const Collection& collection,
                         const std::string& split, Taken taken);

/// The same walks, an object each: instr_id, worker, submitted, seconds, camera, steps.
std::string walks_json(store::Database& database, const Collection& collection,
                       const std::string& split, Taken taken);

}  // namespace enfilade::service::collecting
