/// \file  The network of the continuous agent: an LSTM over the instruction, a GRU over the steps
/// of a rollout (Krantz et al., ECCV 2020, section 4.1).
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/models/train_config.h"
#include "enfilade/neural/core/weights.h"

namespace enfilade::neural::continuous {

/// What an agent of VLN-CE's first task can do: stop, forward, left, right, by
/// enfilade::continuous::Action.
inline constexpr std::int64_t kChoices = 4;
/// The input for the action before: none yet, or 1 + a choice.
inline constexpr std::int64_t kNoAction = 0;
/// Numbers that stand for a depth picture: the means of a grid.
inline constexpr std::int64_t kDepthCells = 16, kDepthSize = kDepthCells * kDepthCells;

/// The sizes of the network that follow from a training's config, with what follows from its data.
struct Sizes {
  std::int64_t words = 0;     ///< ids, those for begin and end among them
  std::int64_t features = 0;  ///< numbers per picture
  models::Seq2SeqCeConfig own;
};
/// Sizes of a config with network.vocabulary and network.features.
Sizes sizes_of(const models::TrainConfig& config);

/// Observations and actions at steps of rollouts; rows as in read_gru().
struct Steps {
  at::Tensor pictures;               ///< (rows, features)
  at::Tensor depth;                  ///< (rows, kDepthSize)
  at::Tensor previous;               ///< (rows) int64, kNoAction or 1 + choice
  std::vector<std::int64_t> counts;  ///< rows of each step: rollouts that are not over
};

/// Parameters, and what they compute, on one device in float32; inputs may be on any. Autograd
/// follows every call, unless a guard is set. One thread at a time.
class CeNetwork {
 public:
  /// Random weights as PyTorch's modules begin with, from a seed.
  CeNetwork(const Sizes& sizes, std::uint64_t seed, c10::Device device = c10::kCPU);
  /// Those of a file. \throws InvalidInput naming every array that is missing, surplus or of
  /// another shape
  CeNetwork(const Sizes& sizes, const features::TensorFile& file, c10::Device device = c10::kCPU);

  const Sizes& sizes() const noexcept { return sizes_; }
  /// By name. Handles to the network's own memory.
  const core::Weights& weights() const noexcept { return weights_; }
  c10::Device device() const noexcept { return device_; }

  /// The LSTM's state at each instruction's end. \param instructions ids, of each one at least
  /// \return (n, sentence) in their order
  at::Tensor read(std::span<const std::vector<std::int64_t>> instructions) const;
  /// The GRU's states along rollouts. \param sentences (counts[0], sentence) per rollout
  /// \param before (counts[0], hidden) \return (rows, hidden)
  at::Tensor walk(const at::Tensor& sentences, const Steps& steps, const at::Tensor& before) const;
  /// The state before the first step: zeros.
  at::Tensor begin(std::int64_t n) const;
  /// Scores of the four choices. \param states (rows, hidden) \return (rows, kChoices)
  at::Tensor score(const at::Tensor& states) const;

 private:
  const at::Tensor& weight(std::string_view name) const;

  Sizes sizes_;
  core::Weights weights_;
  c10::Device device_;
};

/// Cross-entropy to the teacher's choices. A step weighs `inflection` if its choice differs from
/// the step before, or is the first, else 1. The mean by weight of each rollout, and the mean of
/// these.
/// \param scores (rows, kChoices)
/// \param teacher (rows) int64
/// \param counts rows of each step
at::Tensor inflection_loss(const at::Tensor& scores, const at::Tensor& teacher,
                           const std::vector<std::int64_t>& counts, double inflection);

}  // namespace enfilade::neural::continuous
