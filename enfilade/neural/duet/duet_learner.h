/// \file  DUET in training: fine-tuning with a teacher on its map.
#pragma once
#include <c10/core/Device.h>
#include <memory>

#include "enfilade/models/instruction_words.h"
#include "enfilade/neural/detail/learner.h"

namespace enfilade::neural::duet {

/// An iteration has a rollout along the annotated path, one of the agent's own, or both, of the
/// same episodes. In the latter the teacher names a node of the agent's map. TrainConfig::feedback,
/// teacher_weight and map_teacher decide. The published one is an own rollout and a fifth of the
/// annotated one's loss.
/// \param config outlives it
/// \throws as DuetNetwork
std::unique_ptr<detail::Learner> make_duet_learner(const models::TrainConfig& config,
                                                   models::InstructionWords words,
                                                   c10::Device device);

}  // namespace enfilade::neural::duet
