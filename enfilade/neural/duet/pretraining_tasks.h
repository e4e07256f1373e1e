/// \file  DUET's pretraining: the network with its heads, and the tasks: masked words, masked
/// views, the next step, the object.
#pragma once
#include <ATen/core/Tensor.h>
#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/core/enum_names.h"
#include "enfilade/features/tensor_file.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/models/network_config.h"
#include "enfilade/neural/duet/duet_network.h"
#include "enfilade/neural/duet/rollout.h"

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

  /// Scores of all words at masked places. The text attends to the map and to the viewpoint, as
  /// they are before their own layers; the two are added.
  /// \param masked (k) int64: row * longest + place \return (k, vocabulary)
  at::Tensor guess_words(const Tokens& text, const NavigationInput& input, const at::Tensor& masked,
                         RateDropout* dropout = nullptr) const;
  /// Guesses of masked views' features, from the local branch's tokens.
  /// \param masked (k) int64: row * tokens + token \return (k, image). \pre config().image > 0
  at::Tensor guess_views(const NavigationOutput& output, const at::Tensor& masked) const;

 private:
  at::Tensor text_side(const Layers& layers, const Tokens& text, const at::Tensor& vision,
                       const at::Tensor& mask, const char* branch) const;

  DuetNetwork agent_;
  core::Weights weights_;
};

/// The tasks of Chen et al. 2022, section 3.4.
enum class PretrainingTask : std::uint8_t {
  kWords,   ///< the instruction has gaps; the whole path is given
  kViews,   ///< some views are missing where the agent stands, anywhere on the path
  kAction,  ///< the next viewpoint from any on the path, or stop at its end
  kObject,  ///< the instruction's object; the whole path is given
};
constexpr std::array<std::string_view, 4> names_of(PretrainingTask /*enum*/) {
  return {"words", "views", "action", "object"};
}
/// Those that this network has something to learn from.
std::vector<PretrainingTask> pretraining_tasks(const DuetConfig& config,
                                               const models::Inputs& inputs);

/// Input of pretraining: the annotated paths, all their steps at once.
struct PretrainingBatch {
  PretrainingTask task = PretrainingTask::kAction;
  at::Tensor ids, lengths;  ///< of n instructions, as DuetNetwork::encode_text() takes them
  /// A row for each viewpoint of each path, from the agent's view at its arrival. Masked views are
  /// zeros.
  PanoramaInput panoramas;
  at::Tensor rows;    ///< (n * s) int64: the rows of each path, padded with any
  at::Tensor last;    ///< (n) int64: of them the row where the agent stands
  at::Tensor shares;  ///< (n, g, s * longest) of each token in the mean that is a node of the map
  NavigationInput navigation;  ///< without nodes, tokens and token_mask

  at::Tensor masked;  ///< (k) int64 places of words or tokens, as the guesses take them
  at::Tensor words;   ///< (k) int64: what stood there
  at::Tensor views;   ///< (k, image): likewise
  at::Tensor shown;   ///< (k) int64: equal for the same view of the same viewpoint
  at::Tensor node_labels, token_labels;  ///< (n) int64, rows of the map and tokens; kNoLabel
  at::Tensor object_labels;              ///< (n) int64 tokens; likewise
};

/// Random choices of a batch.
struct PretrainingDraws {
  std::uint64_t seed = 1, stream = 0;
  double words = 0.15;      ///< share that is guessed: 8 of 10 masked, 1 another word, 1 as it was
  double views = 0.15;      ///< share that is masked
  double whole_path = 0.2;  ///< of kAction's paths; the others end before the goal
};

/// Walks the episodes for a task. The same draws give the same batch.
/// \pre no reference is empty \throws ArgumentError for a vocabulary without a mask (kWords)
PretrainingBatch pretraining_batch(RolloutRunner& runner, const DuetConfig& config,
                                   const models::InstructionWords& words,
                                   std::span<const RolloutEpisode> episodes, PretrainingTask task,
                                   const PretrainingDraws& draws);

/// The input of the branches: `batch.navigation` with the encoded views.
NavigationInput navigation_of(const DuetNetwork& network, const PretrainingBatch& batch,
                              RateDropout* dropout = nullptr);

/// The mean cross-entropy over the predictions. For masked views it tells the view from the others
/// of the batch, by the products of prediction and normed features. For kAction it is the sum of
/// map, viewpoint and both together. Not defined if there is nothing to predict.
at::Tensor pretraining_loss(const PretrainingNetwork& network, const PretrainingBatch& batch,
                            RateDropout* dropout = nullptr);

}  // namespace enfilade::neural::duet
