/// \file  DUET's fine-tuning: losses of two rollouts, and an update.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/neural/detail/optimizer.h"
#include "enfilade/neural/duet/duet_network.h"
#include "enfilade/neural/duet/rollout.h"

namespace enfilade::neural::duet {

/// A part of an iteration: one batch, with one kind of rollout.
struct TrainingWalk {
  std::span<const WalkEpisode> episodes;
  WalkOptions options;  ///< with an expert
  double weight = 1;    ///< of its loss, which is summed over steps and averaged over episodes
};

/// Result of an iteration.
struct TrainingStep {
  double loss = 0;                 ///< the sum of `losses`
  std::vector<double> losses;      ///< by rollout, weights included
  double norm = 0;                 ///< of the gradients before clipping
  double environment_seconds = 0;  ///< as Rollout's, of all rollouts
};

/// The losses of rollouts, for autograd's backward pass.
struct WalkLosses {
  at::Tensor sum;                  ///< undefined: nothing to learn
  std::vector<at::Tensor> parts;   ///< by rollout, weights included, without gradients; or
                                   ///< undefined
  double environment_seconds = 0;  ///< as Rollout's, of all rollouts
};
WalkLosses walk_for_loss(const DuetNetwork& network, Walker& walker,
                         std::span<const TrainingWalk> walks, const StepWatcher& watcher = {});

/// Walks and adds up the losses; gradients are then those of their sum. The same seeds and weights
/// give the same numbers with the same number of threads. `norm` stays 0.
/// \throws Error for a loss that is not finite
TrainingStep accumulate(const DuetNetwork& network, Walker& walker,
                        std::span<const TrainingWalk> walks, const StepWatcher& watcher = {});

/// accumulate(), and one update of the network. \throws Error for a loss or gradient that is not
/// finite; then no weight has changed
TrainingStep train_once(const DuetNetwork& network, Walker& walker,
                        std::span<const TrainingWalk> walks, detail::Optimizer& optimizer,
                        const StepWatcher& watcher = {});

}  // namespace enfilade::neural::duet
