/// \file  DUET's pretraining tasks: masked words, masked views, the next step, the object.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "enfilade/models/instruction_words.h"
#include "enfilade/models/network_config.h"
#include "enfilade/neural/duet/pretraining_network.h"
#include "enfilade/neural/duet/rollout.h"

namespace enfilade::neural::duet {

/// The tasks of Chen et al. 2022, section 3.4.
enum class PretrainingTask : std::uint8_t {
  kWords,   ///< the instruction has gaps; the whole path is given
  kViews,   ///< some views are missing where the agent stands, anywhere on the path
  kAction,  ///< the next viewpoint from any on the path, or stop at its end
  kObject,  ///< the instruction's object; the whole path is given
};
std::string_view to_string(PretrainingTask task) noexcept;  ///< "words", "views", ...
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
                              Dropout* dropout = nullptr);

/// The mean cross-entropy over the predictions. For masked views it tells the view from the others
/// of the batch, by the products of prediction and normed features. For kAction it is the sum of
/// map, viewpoint and both together. Not defined if there is nothing to predict.
at::Tensor pretraining_loss(const PretrainingNetwork& network, const PretrainingBatch& batch,
                            Dropout* dropout = nullptr);

}  // namespace enfilade::neural::duet
