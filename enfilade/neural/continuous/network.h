/// \file  The network of the continuous agent: an LSTM over the instruction, a GRU over the steps
/// of a rollout (Krantz et al., ECCV 2020, section 4.1).
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/models/train_config.h"
#include "enfilade/neural/core/lstm_parts.h"

namespace enfilade::neural::continuous {

/// The arrays of a GRU, in PyTorch's order of gates: reset, update, new.
struct GruWeights {
  at::Tensor input;                    ///< (3 hidden, in)
  at::Tensor hidden;                   ///< (3 hidden, hidden)
  at::Tensor input_bias, hidden_bias;  ///< (3 hidden)
};

/// Steps of several rows, packed: those of all rows' first steps, then of all second steps, and so
/// on. Shorter rows come after longer ones, so that a step has the first `counts[t]` rows.
///
/// As PyTorch's `GRU`; values and gradients are the same except for rounding. Gradients flow to `x`
/// and the weights.
/// \param x (sum of counts, in) float32 on the CPU
/// \param counts from 1, never rising
/// \param before (counts[0], hidden): the state before the first step
/// \return (sum of counts, hidden): the state after each step
at::Tensor read_gru(const at::Tensor& x, const std::vector<std::int64_t>& counts,
                    const at::Tensor& before, const GruWeights& weights);

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
struct StepRows {
  at::Tensor pictures;               ///< (rows, features)
  at::Tensor depth;                  ///< (rows, kDepthSize)
  at::Tensor previous;               ///< (rows) int64, kNoAction or 1 + choice
  std::vector<std::int64_t> counts;  ///< rows of each step: rollouts that are not over
};

/// Parameters, and what they compute.
class CeNetwork : public core::LstmNetwork {
 public:
  /// Random weights as PyTorch's modules begin with, from a seed.
  CeNetwork(const Sizes& sizes, std::uint64_t seed, c10::Device device = c10::kCPU);
  /// Those of a file. \throws InvalidInput naming every array that is missing, surplus or of
  /// another shape
  CeNetwork(const Sizes& sizes, const features::TensorFile& file, c10::Device device = c10::kCPU);

  const Sizes& sizes() const noexcept { return sizes_; }

  /// The LSTM's state at each instruction's end. \param instructions ids, of each one at least
  /// \return (n, sentence) in their order
  at::Tensor read(std::span<const std::vector<std::int64_t>> instructions) const;
  /// The GRU's states along rollouts. \param sentences (counts[0], sentence) per rollout
  /// \param before (counts[0], hidden) \return (rows, hidden)
  at::Tensor walk(const at::Tensor& sentences, const StepRows& steps,
                  const at::Tensor& before) const;
  /// The state before the first step: zeros.
  at::Tensor begin(std::int64_t n) const;
  /// Scores of the four choices. \param states (rows, hidden) \return (rows, kChoices)
  at::Tensor score(const at::Tensor& states) const;

 private:
  Sizes sizes_;
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
