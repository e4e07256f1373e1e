/// \file  The panoramic LSTM in training: imitation, student-forcing, advantage actor-critic.
#pragma once
#include <c10/core/Device.h>
#include <memory>

#include "enfilade/neural/detail/learner.h"

namespace enfilade::neural::panoramic {

/// An iteration is a teacher-forced rollout, one of the agent's own, or both, of the same episodes.
/// TrainConfig::feedback, teacher_weight and sampled_loss decide. EnvDrop's is an own rollout with
/// rewards and a fifth of the teacher's loss.
/// \param config outlives it
/// \throws as PanoramicNetwork
std::unique_ptr<detail::Learner> make_panoramic_learner(const models::TrainConfig& config,
                                                        const tasks::Vocabulary& vocabulary,
                                                        c10::Device device);

}  // namespace enfilade::neural::panoramic
