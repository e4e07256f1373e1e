/// \file  Evaluating a network on a whole split: greedy trajectories for scores, and the loss.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/models/instructions.h"
#include "enfilade/neural/core/view_features.h"
#include "enfilade/neural/ranks.h"
#include "enfilade/neural/seq2seq/network.h"
#include "enfilade/neural/seq2seq/r2r_environment.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/results.h"

namespace enfilade::neural::seq2seq {

/// A split with its encoded instructions and features. Immutable: any thread may read.
struct PreparedSplit {
  tasks::EpisodeSet episodes;
  models::EncodedInstructions instructions;
  std::optional<core::ViewFeatures> features;  ///< none if the network does not see

  /// Null if there are no features.
  const core::ViewFeatures* view_features() const { return features ? &*features : nullptr; }
};
/// Encodes instructions and looks up features. \param features null without vision
/// \throws as ViewFeatures
PreparedSplit prepare(tasks::EpisodeSet episodes, const tasks::Vocabulary& vocabulary,
                      std::size_t max_words, const features::FeatureSet* features);

/// The actions of one episode, and the attention to the instruction before each.
struct AttentionTrace {
  std::vector<std::int32_t> actions;  ///< `end` included if it was chosen
  /// One weight per word of the row, padding left out; none if the network does not use language.
  std::vector<std::vector<float>> attention;
};

/// The walks of all episodes of a split.
struct GreedyRollout {
  std::vector<tasks::Trajectory> trajectories;  ///< one per episode, in order
  std::vector<AttentionTrace> traces;           ///< likewise
};

/// Sizes of a walk.
struct BatchOptions {
  std::size_t batch_size = 100;  ///< episodes at once
  std::size_t max_steps = 20;    ///< actions of an episode
  Ranks* ranks = nullptr;        ///< processes that do batches in turn; all have all results
};

/// Walks all episodes, with the most likely action at every step and no dropout, to `end` or
/// max_steps.
/// \throws ArgumentError if the network does not fit the split
GreedyRollout rollout_greedily(Network& network, const PreparedSplit& split,
                               const BatchOptions& options = {}, const Progress& progress = {});

/// Options of compute_loss().
struct LossOptions {
  BatchOptions batches;
  RolloutOptions rollout;  ///< its stream is that of the first batch; each batch takes the next
  models::AfterEnd after_end = models::AfterEnd::kWalksOn;
  models::ForwardTo forward = models::ForwardTo::kNearest;
};
/// The loss as the released code logs it: summed over steps, divided by max_steps. Here it is
/// averaged over episodes.
/// \pre options.rollout.feedback is not kArgmax; the split's goals are known
double compute_loss(Network& network, const PreparedSplit& split, const LossOptions& options);

/// Writes `results/<split>.json` and `results/<split>.attention.json` of a model directory. The
/// latter, unless its name is empty, has the first `attention_episodes` episodes. If the split can
/// be scored, it also has a third as many of the best by SPL and of the worst by navigation error.
/// \throws FileError
void write_rollout(const std::filesystem::path& results, const std::filesystem::path& attention,
                   const GreedyRollout& walk, const PreparedSplit& split,
                   const tasks::Vocabulary& vocabulary, std::size_t attention_episodes = 60);

}  // namespace enfilade::neural::seq2seq
