/// \file  Benchmarks made only from Room-to-Room's paths and instructions: R2R-Last, R2R-Back and
/// fine-grained R2R. Internal.
#pragma once
#include <vector>

#include "enfilade/homes/instructions/speaker.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::homes::benchmarks {

/// R2R-Last: the last sentence of each instruction.
tasks::PathAnnotation last_sentences(tasks::PathAnnotation path);
/// R2R-Back: the path and its way back, with a sentence that requests it. The turning point is the
/// path's end.
tasks::PathAnnotation there_and_back(tasks::PathAnnotation path);
/// Fine-grained R2R: the pieces of each instruction and of the path.
/// \param spoken  of each instruction \pre as many as instructions
tasks::PathAnnotation in_pieces(tasks::PathAnnotation path,
                                const std::vector<std::vector<instructions::SpokenPart>>& spoken);

}  // namespace enfilade::homes::benchmarks
