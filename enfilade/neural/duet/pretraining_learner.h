/// \file  DUET in training: pretraining by guessing.
#pragma once
#include <c10/core/Device.h>
#include <memory>

#include "enfilade/models/instruction_words.h"
#include "enfilade/neural/detail/learner.h"

namespace enfilade::neural::duet {

/// An iteration is one batch of one of the network's pretraining tasks, drawn with equal chances.
/// Validation losses are means over the tasks; trajectories are the fine-tuned agent's.
/// \param config outlives it; its stage is kPretrain
/// \throws as DuetNetwork
std::unique_ptr<detail::Learner> make_pretraining_learner(const models::TrainConfig& config,
                                                          models::InstructionWords words,
                                                          c10::Device device);

}  // namespace enfilade::neural::duet
