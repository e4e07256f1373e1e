/// \file  Instruction ids of all benchmarks.
#pragma once
#include <cstddef>
#include <string>

#include "enfilade/tasks/annotations.h"

namespace enfilade::tasks {

/// The `instr_id` of instruction k: as its file has it, else made of the path's id.
/// \pre k < path.instructions.size()
std::string instruction_id(const PathAnnotation& path, std::size_t k);

}  // namespace enfilade::tasks
