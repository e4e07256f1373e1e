/// \file  One update of a network on libtorch's autograd, from the parts of a batch.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>

#include "enfilade/neural/core/gradient_sum.h"
#include "enfilade/neural/core/optimizer.h"
#include "enfilade/neural/ranks.h"

namespace enfilade::neural::core {

/// The episodes of a loss.
struct BatchPart {
  std::span<const std::size_t> episodes;
  /// Names the random numbers: no other part or iteration has the same. For a batch in one part,
  /// the iteration.
  std::uint64_t stream = 0;
};
/// The mean over the episodes; undefined: there is nothing to learn.
using LossOf = std::function<at::Tensor(const BatchPart&)>;

/// Learns from batches, in parts where there are several. One thread at a time.
class PartedLearning {
 public:
  /// All outlive *this, and the weights stay the same tensors. \param parts of TrainConfig
  /// \throws ArgumentError as share_parts()
  PartedLearning(Ranks& ranks, std::size_t parts, const Weights& weights, Optimizer& optimizer);

  /// Follows the losses back and updates the weights. The mean of parts of unlike sizes is
  /// weighted by these. \return the loss of the batch \throws Error if it is not finite; LostRank
  double learn(std::span<const std::size_t> batch, std::uint64_t iteration, const LossOf& loss_of);

 private:
  const Weights& weights_;
  Optimizer& optimizer_;
  std::optional<GradientSum> sum_;  // none: one part, one process
  std::optional<ReadyWatch> watch_;
};

}  // namespace enfilade::neural::core
