/// \file  DUET in training: fine-tuning with a teacher on its map, and pretraining.
#pragma once
#include <c10/core/Device.h>
#include <memory>
#include <span>
#include <vector>

#include "enfilade/models/instruction_words.h"
#include "enfilade/neural/core/learner.h"
#include "enfilade/neural/duet/rollout.h"

namespace enfilade::neural::duet {

/// A part of an iteration: one batch, rolled out in one way.
struct WeightedRollout {
  std::span<const RolloutEpisode> episodes;
  RolloutOptions options;  ///< with an expert
  double weight = 1;       ///< of its loss, which is summed over steps and averaged over episodes
};
/// The losses of rollouts, which autograd can follow back.
struct RolloutLosses {
  at::Tensor sum;                  ///< weights included; undefined: there is nothing to learn
  double environment_seconds = 0;  ///< as Rollout's, of all rollouts
};
RolloutLosses rollout_for_loss(const DuetNetwork& network, RolloutRunner& runner,
                               std::span<const WeightedRollout> rollouts,
                               const StepWatcher& watcher = {});

/// An iteration has one or both of two rollouts of the same episodes. One follows the annotated
/// path. The other is the agent's own, with a teacher that names a node of its map.
/// TrainConfig::feedback, teacher_weight and map_teacher choose. The published iteration is an own
/// rollout and a fifth of the annotated one's loss.
/// \param config outlives it
/// \throws as DuetNetwork
std::unique_ptr<core::Learner> make_duet_learner(const models::TrainConfig& config,
                                                 models::InstructionWords words,
                                                 c10::Device device);

/// An iteration is one batch of one of the network's pretraining tasks, drawn with equal chances.
/// Validation losses are means over the tasks; walks are the fine-tuned agent's.
/// \param config outlives it; its stage is kPretrain \throws as DuetNetwork
std::unique_ptr<core::Learner> make_pretraining_learner(const models::TrainConfig& config,
                                                        models::InstructionWords words,
                                                        c10::Device device);

}  // namespace enfilade::neural::duet
