/// \file  The panoramic LSTM agent's network: EnvDrop's listener (Tan, Yu, Bansal 2019).
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <cstdint>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/models/network_config.h"
#include "enfilade/neural/core/lstm_parts.h"
#include "enfilade/neural/core/recurrent_ops.h"
#include "enfilade/neural/core/weights.h"

namespace enfilade::neural::panoramic {

using models::PanoramicConfig;
using models::Subout;

/// The arrays of encoder, decoder and critic, by the names of the published code.
std::vector<core::ArraySpec> array_specs(const PanoramicConfig& config);

/// The sizes of a file of weights, from the shapes of its arrays. Dropout and `subout` are those of
/// `defaults`, as no shape gives them.
/// \throws InvalidInput naming each array that is missing or of another number of sides
PanoramicConfig config_of(const features::TensorFile& file, const PanoramicConfig& defaults);

/// Sentences as the encoder reads them: rows by falling number of words.
struct WordBatch {
  at::Tensor ids;                     ///< (n, longest) int64, 0 at padding
  std::vector<std::int64_t> lengths;  ///< (n) from 1, falling
};

/// Output of the encoder.
struct Encoding {
  at::Tensor context;           ///< (n, longest, hidden): forward, then backward; zeros at padding
  at::Tensor mask;              ///< (n, longest) bool: true at padding
  core::AttentionMemory words;  ///< the context, to attend to
  at::Tensor start;             ///< (n, hidden) the decoder's first state
  at::Tensor cell;              ///< (n, hidden) its first cell state: backward, then forward
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

/// Parameters, and the functions of the network.
///
/// The maximum of Subout::kMax runs over the padded length with zeros there, as in the published
/// code. So an episode's results depend on the longest sentence of its batch.
class PanoramicNetwork : public core::LstmNetwork {
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

  /// \throws ArgumentError for lengths that do not fall, or ids beyond the vocabulary
  Encoding encode(const WordBatch& words);
  /// \pre sizes fit each other and the configuration
  StepOutput step(const Encoding& encoding, const DecoderState& state, const StepInput& input);
  /// The value of a state. \param hidden (n, hidden) \return (n)
  at::Tensor value(const at::Tensor& hidden);

 private:
  at::Tensor drop_images(const at::Tensor& features, FeaturesDropped dropped);
  at::Tensor linear(const at::Tensor& x, const std::string& name) const;

  PanoramicConfig config_;
};

}  // namespace enfilade::neural::panoramic
