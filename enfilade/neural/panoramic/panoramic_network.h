/// \file  The panoramic LSTM agent's network: EnvDrop's listener (Tan, Yu, Bansal 2019).
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <cstdint>
#include <optional>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/neural/core/dropout.h"
#include "enfilade/neural/core/recurrent_ops.h"
#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/panoramic/panoramic_config.h"

namespace enfilade::neural::panoramic {

/// Sentences as the encoder reads them: rows by falling number of words.
struct WordBatch {
  at::Tensor ids;                     ///< (n, longest) int64, 0 at padding
  std::vector<std::int64_t> lengths;  ///< (n) from 1, falling
};

/// Output of the encoder.
struct Encoding {
  at::Tensor context;  ///< (n, longest, hidden): forward, then backward; zeros at padding
  at::Tensor mask;     ///< (n, longest) bool: true at padding
  core::Memory words;  ///< the context, to attend to
  at::Tensor start;    ///< (n, hidden) the decoder's first state
  at::Tensor cell;     ///< (n, hidden) its first cell state: backward, then forward
};

/// Which code drops a part of the pictures' numbers.
enum class FeaturesDropped : std::uint8_t {
  kByNetwork,  ///< the network does, when dropout is on: each number for itself
  kBefore,     ///< they were when the pictures were read (EnvironmentalDropout): the network does
               ///< not
};

/// Input of the agents before an action.
struct StepInput {
  at::Tensor action;      ///< (n, angle) the agent's own heading and elevation
  at::Tensor views;       ///< (n, 36, feature)
  at::Tensor candidates;  ///< (n, most, feature); zeros in the slot of stop and behind it
  at::Tensor closed;      ///< (n, most) bool: true behind the slot of stop
  FeaturesDropped dropped = FeaturesDropped::kByNetwork;
};

/// The decoder's memory.
struct DecoderState {
  at::Tensor
      tilde;  ///< (n, hidden) hidden state after attention to the words; first Encoding::start
  at::Tensor cell;  ///< (n, hidden)
};

/// Output of a step.
struct StepOutput {
  DecoderState next;
  at::Tensor hidden;          ///< (n, hidden) of the LSTM: the critic's input
  at::Tensor logits;          ///< (n, most); minus infinity where `closed`; exactly 0 for stop
  at::Tensor attended_view;   ///< (n, feature)
  at::Tensor view_attention;  ///< (n, 36), of sum 1
  at::Tensor word_attention;  ///< (n, longest), of sum 1, 0 at padding
};

/// Parameters, and the functions of the network. Autograd follows every call, unless a guard is
/// set. In float32, on one device; inputs may be on any. One thread at a time.
///
/// The maximum of Subout::kMax runs over the padded length with zeros there, as in the published
/// code. So an episode's results depend on the longest sentence of its batch.
class PanoramicNetwork {
 public:
  /// Random weights as PyTorch's modules begin with, from a seed. \throws ArgumentError as
  /// validate()
  PanoramicNetwork(const PanoramicConfig& config, std::uint64_t seed,
                   c10::Device device = c10::kCPU);
  /// Those of a file: `.npz` or safetensors with the published names, or EnvDrop's checkpoint.
  /// \throws InvalidInput naming every array that is missing, surplus or of another shape
  PanoramicNetwork(const PanoramicConfig& config, const features::TensorFile& file,
                   c10::Device device = c10::kCPU);

  const PanoramicConfig& config() const noexcept { return config_; }
  /// By the published names. Handles to the network's own memory.
  const core::Weights& weights() const noexcept { return weights_; }
  c10::Device device() const noexcept { return device_; }
  /// \throws LookupError for an unknown name
  const at::Tensor& weight(std::string_view name) const;

  /// Turns dropout on, drawing from this seed. No value: off, as at first.
  void set_dropout(std::optional<std::uint64_t> seed);

  /// \throws ArgumentError for lengths that do not fall, or ids beyond the vocabulary
  Encoding encode(const WordBatch& words);
  /// \pre sizes fit each other and the configuration
  StepOutput step(const Encoding& encoding, const DecoderState& state, const StepInput& input);
  /// The value of a state. \param hidden (n, hidden) \return (n)
  at::Tensor value(const at::Tensor& hidden);

 private:
  at::Tensor drop(const at::Tensor& x, double rate);
  at::Tensor drop_images(const at::Tensor& features, FeaturesDropped dropped);
  at::Tensor linear(const at::Tensor& x, const std::string& name) const;

  PanoramicConfig config_;
  core::Weights weights_;
  c10::Device device_;
  std::optional<core::Dropout> dropout_;
};

}  // namespace enfilade::neural::panoramic
