/// \file  The network that describes a path in words: EnvDrop's speaker (Tan, Yu, Bansal 2019).
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/models/speaker_config.h"
#include "enfilade/neural/core/dropout.h"
#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/panoramic/panoramic_network.h"

namespace enfilade::neural::speaker {

using models::SpeakerConfig;
using panoramic::FeaturesDropped;

/// The arrays of the speaker's encoder and decoder, by the names of the published code.
std::vector<core::ArraySpec> array_specs(const SpeakerConfig& config);

/// The sizes of a file of weights, from the shapes of its arrays. `angle` and dropout are those of
/// `defaults`, as no shape gives them.
/// \throws InvalidInput naming each array that is missing or of another number of sides
SpeakerConfig speaker_config_of(const features::TensorFile& file, const SpeakerConfig& defaults);

/// Paths as the encoder reads them. A step is a viewpoint and the choice that is made there; the
/// last choice is to stop.
struct PathBatch {
  at::Tensor actions;  ///< (n, longest, feature) the candidates that are chosen; zeros for stop
  at::Tensor views;    ///< (n, longest, 36, feature); behind a path's end nothing is read
  std::vector<std::int64_t> lengths;  ///< (n) steps, stop among them, from 1 to longest
  FeaturesDropped dropped = FeaturesDropped::kByNetwork;
};

/// Output of the encoder.
struct PathEncoding {
  at::Tensor context;  ///< (n, longest, hidden); zeros behind a path's end
  at::Tensor mask;     ///< (n, longest) bool: true behind a path's end
};

/// The decoder's memory.
struct SpeakerState {
  at::Tensor hidden, cell;  ///< (n, hidden)
};

/// Parameters, and the functions of the network. Autograd follows every call, unless a guard is
/// set. In float32, on one device; inputs may be on any. One thread at a time.
///
/// Nothing is read after the end of a path. The published code pads to the longest path of the
/// batch and lets its backward LSTM begin there, so its results depend on the batch. With paths of
/// one length, or one at a time, both are the same.
class SpeakerNetwork {
 public:
  /// Random weights as PyTorch's modules begin with, from a seed. \throws ArgumentError as
  /// validate()
  SpeakerNetwork(const SpeakerConfig& config, std::uint64_t seed, c10::Device device = c10::kCPU);
  /// Those of a file: `.npz` or safetensors with the published names, or EnvDrop's checkpoint.
  /// `decoder.baseline_projection`, which the published code has and does not use here, is ignored.
  /// \throws InvalidInput naming every array that is missing, surplus or of another shape
  SpeakerNetwork(const SpeakerConfig& config, const features::TensorFile& file,
                 c10::Device device = c10::kCPU);

  const SpeakerConfig& config() const noexcept { return config_; }
  /// By the published names. Handles to the network's own memory.
  const core::Weights& weights() const noexcept { return weights_; }
  /// \throws LookupError for an unknown name
  const at::Tensor& weight(std::string_view name) const;

  /// Turns dropout on, drawing from this seed. No value: off, as at first.
  void set_dropout(std::optional<std::uint64_t> seed);

  /// \throws ArgumentError for sizes that do not fit each other or the configuration
  PathEncoding encode(const PathBatch& paths);
  /// The state before the first word: zeros.
  SpeakerState begin(std::int64_t n) const;
  /// Reads words one after another, from `state`, which becomes that after the last of them.
  /// \param words (n, length) int64, at least one; what stands behind an `<EOS>` changes nothing
  ///     before it
  /// \return (n, length, vocabulary): logits of each word's successor
  /// \throws ArgumentError for ids beyond the vocabulary, or other rows than the encoding's
  at::Tensor decode(const PathEncoding& encoding, const at::Tensor& words, SpeakerState& state);

 private:
  at::Tensor drop(const at::Tensor& x, double rate);
  at::Tensor drop_images(const at::Tensor& features, FeaturesDropped dropped);
  at::Tensor read_steps(const at::Tensor& x, const PathBatch& paths, const std::string& name);

  SpeakerConfig config_;
  core::Weights weights_;
  c10::Device device_;
  std::optional<core::Dropout> dropout_;
};

}  // namespace enfilade::neural::speaker
