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
  std::vector<at::Tensor> losses;  // read at the end, as a card computes them later
  at::Tensor total;
  for (const TrainingWalk& part : walks) {
    const Rollout rollout = walker.walk(network, part.episodes, part.options, watcher);
    losses.emplace_back();
    result.environment_seconds += rollout.environment_seconds;
    if (!rollout.loss.defined()) continue;
    const at::Tensor loss =
        rollout.loss * (part.weight / static_cast<double>(part.episodes.size()));
    losses.back() = loss.detach();
    total = total.defined() ? total + loss : loss;
  }
  if (total.defined()) result.loss = detail::follow_back(total);
  for (const at::Tensor& loss : losses) {
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
