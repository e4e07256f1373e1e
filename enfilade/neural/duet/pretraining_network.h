/// \file  DUET with the heads of its pretraining.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
#include <vector>

#include "enfilade/features/tensor_file.h"
#include "enfilade/neural/duet/duet_network.h"

namespace enfilade::neural::duet {

/// The arrays that pretraining adds to those of the network, by their published names:
/// - the language side of the cross-modal layers
/// - the head for masked words ("mlm_head"), whose last map is the table of word embeddings
/// - the head for masked views ("image_classifier")
std::vector<core::ArraySpec> pretraining_arrays_of(const DuetConfig& config);

/// The network, and what guesses masked words and views with it (Chen et al. 2022, section 3.4).
/// One thread at a time.
class PretrainingNetwork {
 public:
  /// The network has the random weights of DuetNetwork(config, seed).
  PretrainingNetwork(const DuetConfig& config, std::uint64_t seed, c10::Device device = c10::kCPU);
  /// The network has the weights of a file. So have the heads if all of them are in it; else they
  /// have random ones.
  /// \throws InvalidInput as DuetNetwork, for some of the heads' arrays too
  PretrainingNetwork(const DuetConfig& config, const features::TensorFile& file, std::uint64_t seed,
                     c10::Device device = c10::kCPU);

  const DuetNetwork& agent() const noexcept { return agent_; }  ///< the agent's network
  const DuetConfig& config() const noexcept { return agent_.config(); }
  c10::Device device() const noexcept { return agent_.device(); }
  /// Of network and heads; handles to the same memory. The network of a file with all of them can
  /// be read as a DuetNetwork.
  const core::Weights& weights() const noexcept { return weights_; }
  std::vector<core::ArraySpec> arrays() const;  ///< names and shapes of weights()

  /// Scores of all words at masked places. The text attends to the map and to the viewpoint, as
  /// they are before their own layers; the two are added.
  /// \param masked (k) int64: row * longest + place \return (k, vocabulary)
  at::Tensor guess_words(const Tokens& text, const NavigationInput& input, const at::Tensor& masked,
                         Dropout* dropout = nullptr) const;
  /// Guesses of masked views' features, from the local branch's tokens.
  /// \param masked (k) int64: row * tokens + token \return (k, image). \pre config().image > 0
  at::Tensor guess_views(const NavigationOutput& output, const at::Tensor& masked) const;

 private:
  at::Tensor text_side(const Layers& layers, const Tokens& text, const at::Tensor& vision,
                       const at::Tensor& mask, const char* branch) const;

  DuetNetwork agent_;
  core::Weights weights_;
};

}  // namespace enfilade::neural::duet
