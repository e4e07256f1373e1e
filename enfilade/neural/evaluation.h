/// \file  Walking a whole split with a network: greedily for scores, with a teacher for the loss.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/models/instructions.h"
#include "enfilade/neural/network.h"
#include "enfilade/neural/r2r_environment.h"
#include "enfilade/neural/view_features.h"
#include "enfilade/r2r/annotations.h"
#include "enfilade/r2r/results.h"
#include "enfilade/r2r/score.h"

namespace enfilade::neural {

/// A split, ready for a network to walk through. Immutable: any thread.
struct PreparedSplit {
  r2r::EpisodeSet episodes;
  models::EncodedInstructions instructions;
  std::optional<ViewFeatures> features;  ///< none: the network does not see

  const ViewFeatures* view_features() const { return features ? &*features : nullptr; }
};
/// `features`: null if the network does not see. \throws as ViewFeatures
PreparedSplit prepare(r2r::EpisodeSet episodes, const r2r::Vocabulary& vocabulary,
                      std::size_t max_words, const features::FeatureSet* features);

/// What an agent looked at in its instruction before each of its actions.
struct AttentionTrace {
  std::vector<std::int32_t> actions;  ///< `end` included, if it said so
  /// One number a place of the row up to its padding; none if the network hears nothing.
  std::vector<std::vector<float>> attention;
};

/// What a trained agent did in each episode of a split.
struct GreedyWalk {
  std::vector<r2r::Trajectory> trajectories;  ///< one an episode, in order
  std::vector<AttentionTrace> traces;         ///< likewise
};

/// How evaluation walks.
struct WalkOptions {
  std::size_t batch_size = 100;
  std::size_t max_steps = 20;
};

/// The likeliest action at every step, no dropout, from start to `end` or max_steps.
/// \throws ArgumentError if the network does not fit the split
GreedyWalk walk_greedily(Network& network, const PreparedSplit& split,
                         const WalkOptions& options = {}, const Progress& progress = {});

/// The loss of the recipe as it logs it: summed over steps, by max_steps; here averaged over
/// episodes. \pre options.feedback is not kArgmax; the split's goals are known
struct LossOptions {
  WalkOptions walk;
  RolloutOptions rollout;  ///< its stream is the first one; each batch takes the next
  models::AfterEnd after_end = models::AfterEnd::kWalksOn;
  models::ForwardTo forward = models::ForwardTo::kNearest;
};
double compute_loss(Network& network, const PreparedSplit& split, const LossOptions& options);

/// `results/<split>.json` and `results/<split>.attention.json` of a model's folder.
/// The latter holds the first `attention_episodes` episodes and, if the split can be scored, a
/// third as many of the best by SPL and of the worst by navigation error.
/// \throws FileError
void write_walk(const std::filesystem::path& results, const std::filesystem::path& attention,
                const GreedyWalk& walk, const PreparedSplit& split,
                const r2r::Vocabulary& vocabulary, std::size_t attention_episodes = 60);

}  // namespace enfilade::neural
