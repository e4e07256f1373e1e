#include "enfilade/neural/duet/training.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <cmath>

#include "enfilade/core/errors.h"

namespace enfilade::neural::duet {
TrainingStep accumulate(const DuetNetwork& network, Walker& walker,
                        std::span<const TrainingWalk> walks, const StepWatcher& watcher) {
  detail::clear_gradients(network.weights());
  TrainingStep result;
  at::Tensor total;
  for (const TrainingWalk& part : walks) {
    const Rollout rollout = walker.walk(network, part.episodes, part.options, watcher);
    result.losses.push_back(0);
    result.environment_seconds += rollout.environment_seconds;
    if (!rollout.loss.defined()) continue;
    const at::Tensor loss =
        rollout.loss * (part.weight / static_cast<double>(part.episodes.size()));
    result.losses.back() = loss.item<double>();
    total = total.defined() ? total + loss : loss;
  }
  if (total.defined()) result.loss = detail::follow_back(total);
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
