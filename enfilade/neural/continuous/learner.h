/// \file  The continuous agent in training: DAgger (Ross, Gordon, Bagnell 2011).
#pragma once
#include <c10/core/Device.h>
#include <functional>
#include <memory>

#include "enfilade/models/instruction_words.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/neural/core/learner.h"

namespace enfilade::neural::continuous {

/// Before the first update that needs a set of walks it gathers them, into `walks/` of the model
/// directory, a file a building: `walks/02/home0001.safetensors`. What is there of the same weights
/// is kept, so that a training that was killed goes on.
/// \param config outlives it \param told of each set while it is gathered; may be empty
std::unique_ptr<core::Learner> make_learner(
    const models::TrainConfig& config, const tasks::Vocabulary& vocabulary,
    const models::ModelFiles& files, c10::Device device,
    const std::function<void(const GatheringProgress&)>& told);

}  // namespace enfilade::neural::continuous
