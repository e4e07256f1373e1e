/// \file  The network's weights, gradients and moments, each in one contiguous array.
#pragma once
#include <ATen/ATen.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "enfilade/neural/seq2seq/network.h"

namespace enfilade::neural::seq2seq {

enum class Weight : std::uint8_t {
  kWordEmbedding,
  kEncoderInput,
  kEncoderHidden,
  kEncoderInputBias,
  kEncoderHiddenBias,
  kStart,
  kStartBias,
  kActionEmbedding,
  kDecoderInput,
  kDecoderHidden,
  kDecoderInputBias,
  kDecoderHiddenBias,
  kAttentionIn,
  kAttentionOut,
  kAction,
  kActionBias,
};
inline constexpr std::size_t kWeights = 16;

struct WeightInfo {
  const char* name = nullptr;  ///< of this weight in the released code
  std::vector<std::int64_t> shape;
  /// Initial values are uniform within 1/sqrt(inputs) of 0; if this is 0, normal.
  std::int64_t inputs = 0;
  std::int64_t begin = 0;  ///< index in the flat arrays
  std::int64_t elements = 0;
};
std::array<WeightInfo, kWeights> weight_infos(const models::NetworkConfig& config);

/// The flat arrays. Weights begin at aligned positions; gaps between them are zero.
class Parameters {
 public:
  Parameters(const models::NetworkConfig& config, const at::TensorOptions& options);

  /// Sets the weights to random numbers that follow from `seed`, the same on every device, with
  /// PyTorch's distributions. Embeddings are normal (row 0 of the words, PAD, is zero), LSTM
  /// weights uniform within 1/sqrt(hidden) of 0, linear weights within 1/sqrt(inputs). Gradients
  /// and moments become 0.
  void initialise(std::uint64_t seed);

  const std::array<WeightInfo, kWeights>& infos() const noexcept { return infos_; }
  const at::Tensor& weight(Weight which) const { return weights_[index(which)]; }
  const at::Tensor& gradient(Weight which) const { return gradients_[index(which)]; }
  /// A part of a flat array, in the shape of weight i.
  at::Tensor view(const at::Tensor& flat, std::size_t i) const;

  at::Tensor flat_weights, flat_gradients, first, second;
  std::uint64_t updates = 0;

 private:
  static std::size_t index(Weight which) { return static_cast<std::size_t>(which); }

  std::array<WeightInfo, kWeights> infos_;
  std::array<at::Tensor, kWeights> weights_, gradients_;
};

}  // namespace enfilade::neural::seq2seq
