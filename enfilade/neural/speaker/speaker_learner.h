/// \file  The speaker in training: each word of people's instructions, after those before it.
#pragma once
#include <c10/core/Device.h>
#include <memory>

#include "enfilade/neural/core/learner.h"

namespace enfilade::neural::speaker {

/// An iteration is a batch of instructions with their paths; its loss the mean cross-entropy of
/// their words. \param config outlives it
/// \throws as SpeakerNetwork
std::unique_ptr<core::Learner> make_speaker_learner(const models::TrainConfig& config,
                                                    const tasks::Vocabulary& vocabulary,
                                                    c10::Device device);

}  // namespace enfilade::neural::speaker
