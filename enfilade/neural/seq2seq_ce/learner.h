/// \file  The continuous agent in training: DAgger (Ross, Gordon, Bagnell 2011).
#pragma once
#include <c10/core/Device.h>
#include <functional>
#include <memory>

#include "enfilade/models/instruction_words.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/neural/detail/learner.h"

namespace enfilade::neural::seq2seq_ce {

/// Before the first update that needs a set of rollouts it gathers them, into `walks/` of the model
/// directory, one file per building: `walks/02/home0001.safetensors`. Existing files of the same
/// weights are kept, so that a killed training can be continued.
/// \param config outlives it
/// \param told is called with each set's progress while it is gathered; may be empty
std::unique_ptr<detail::Learner> make_learner(
    const models::TrainConfig& config, const tasks::Vocabulary& vocabulary,
    const models::ModelFiles& files, c10::Device device,
    const std::function<void(const GatheringProgress&)>& told);

}  // namespace enfilade::neural::seq2seq_ce
