/// \file  The sequence-to-sequence agent in training.
#pragma once
#include <memory>
#include <string>

#include "enfilade/neural/core/learner.h"

namespace enfilade::neural::seq2seq {

/// \param config, vocabulary outlive it \throws as Network
std::unique_ptr<core::Learner> make_learner(const models::TrainConfig& config,
                                            const tasks::Vocabulary& vocabulary,
                                            const std::string& device);

}  // namespace enfilade::neural::seq2seq
