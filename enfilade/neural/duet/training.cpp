#include "enfilade/neural/duet/training.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <cmath>

#include "enfilade/core/errors.h"

namespace enfilade::neural::duet {

WalkLosses walk_for_loss(const DuetNetwork& network, Walker& walker,
                         std::span<const TrainingWalk> walks, const StepWatcher& watcher) {
  WalkLosses result;
  for (const TrainingWalk& part : walks) {
    const Rollout rollout = walker.walk(network, part.episodes, part.options, watcher);
    result.parts.emplace_back();
    result.environment_seconds += rollout.environment_seconds;
    if (!rollout.loss.defined()) continue;
    const at::Tensor loss =
        rollout.loss * (part.weight / static_cast<double>(part.episodes.size()));
    result.parts.back() = loss.detach();
    result.sum = result.sum.defined() ? result.sum + loss : loss;
  }
  return result;
}

TrainingStep accumulate(const DuetNetwork& network, Walker& walker,
                        std::span<const TrainingWalk> walks, const StepWatcher& watcher) {
  detail::clear_gradients(network.weights());
  const WalkLosses losses = walk_for_loss(network, walker, walks, watcher);
  TrainingStep result;
  result.environment_seconds = losses.environment_seconds;
  if (losses.sum.defined()) result.loss = detail::follow_back(losses.sum);
  // Read at the end, as a card computes them later.
  for (const at::Tensor& loss : losses.parts) {
    result.losses.push_back(loss.defined() ? loss.item<double>() : 0);
  }
  return result;
}

TrainingStep train_once(const DuetNetwork& network, Walker& walker,
                        std::span<const TrainingWalk> walks, detail::Optimizer& optimizer,
                        const StepWatcher& watcher) {
  TrainingStep result = accumulate(network, walker, walks, watcher);
  result.norm = optimizer.update(network.weights());
  return result;
}

}  // namespace enfilade::neural::duet
