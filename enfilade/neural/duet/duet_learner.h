/// \file  DUET in training: fine-tuning with a teacher on its map.
#pragma once
#include <c10/core/Device.h>
#include <memory>

#include "enfilade/models/instruction_words.h"
#include "enfilade/neural/detail/learner.h"

namespace enfilade::neural::duet {

/// An iteration is a walk along the annotated path, one of the agent's own with a teacher that
/// names a node of its map, or both, of the same episodes: as TrainConfig::feedback, teacher_weight
/// and map_teacher say. The published one is an own walk and a fifth of the annotated one's loss.
/// \param config outlives it \throws as DuetNetwork
std::unique_ptr<detail::Learner> make_duet_learner(const models::TrainConfig& config,
                                                   models::InstructionWords words,
                                                   c10::Device device);

}  // namespace enfilade::neural::duet
