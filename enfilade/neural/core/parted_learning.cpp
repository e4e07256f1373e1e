#include "enfilade/neural/core/parted_learning.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>

#include <vector>

namespace enfilade::neural::core {

PartedLearning::PartedLearning(Ranks& ranks, std::size_t parts, const Weights& weights,
                               Optimizer& optimizer)
    : weights_(weights), optimizer_(optimizer) {
  const BatchParts shared = share_parts(parts, ranks);
  if (shared.parts == 1) return;
  std::vector<std::int64_t> sizes;
  for (const auto& [name, weight] : weights) sizes.push_back(weight.numel());
  sum_.emplace(ranks, shared, std::move(sizes), weights.begin()->second.device());
  if (!ranks.alone()) watch_.emplace(weights, *sum_);
}

double PartedLearning::learn(std::span<const std::size_t> batch, std::uint64_t iteration,
                             const LossOf& loss_of) {
  const auto follow = [&](const BatchPart& part) {
    const at::Tensor loss = loss_of(part);
    return loss.defined() ? follow_back(loss) : 0;
  };
  if (!sum_) {
    const double value = follow({batch, iteration});
    optimizer_.update(weights_);  // where nothing was learnt the rate has one step less to go
    return value;
  }
  const BatchParts& own = sum_->parts();
  for (std::size_t k = own.first; k < own.first + own.count; ++k) {
    const auto episodes = part_of(batch, k, own.parts);
    sum_->begin_part(static_cast<double>(episodes.size()) / static_cast<double>(batch.size()));
    const double loss = episodes.empty() ? 0 : follow({episodes, iteration * own.parts + k});
    std::vector<at::Tensor> gradients;
    for (const auto& [name, weight] : weights_) gradients.push_back(weight.grad());
    sum_->end_part(gradients, loss);
    clear_gradients(weights_);
  }
  const GradientSum::Sums sums = sum_->finish();
  std::size_t k = 0;
  for (const auto& [name, weight] : weights_) {
    const at::Tensor& sum = sums.gradients[k++];
    if (!sum.defined()) continue;
    at::Tensor(weight).mutable_grad() = sum.view(weight.sizes());
  }
  optimizer_.update(weights_);
  return sums.loss;
}

}  // namespace enfilade::neural::core
