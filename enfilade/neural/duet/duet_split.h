/// \file  A split for DUET, and the loss of its rollouts.
#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/features/object_set.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/models/train_config.h"
#include "enfilade/neural/core/view_features.h"
#include "enfilade/neural/duet/rollout.h"
#include "enfilade/neural/trained_agent.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::neural::duet {

/// Episodes with their instructions as ids, and the features of their buildings. One thread at a
/// time.
class DuetSplit {
 public:
  /// `episodes` and `words` have to outlive *this.
  /// \param features null if the agent does not use vision
  /// \param objects may be null for an agent that names none
  /// \throws as ViewFeatures; ArgumentError for objects that are missing or of another size
  DuetSplit(const tasks::EpisodeSet& episodes, const models::InstructionWords& words,
            const models::TrainConfig& config, const features::FeatureSet* features,
            std::shared_ptr<const features::ObjectSet> objects = nullptr);
  DuetSplit(const DuetSplit&) = delete;
  DuetSplit& operator=(const DuetSplit&) = delete;

  const tasks::EpisodeSet& episodes() const noexcept { return episodes_; }
  /// The episodes with these indices, to be walked.
  std::vector<RolloutEpisode> batch(std::span<const std::size_t> episodes) const;
  const RolloutEpisode& episode(std::size_t index) const { return walks_[index]; }
  RolloutRunner& runner() noexcept { return *runner_; }
  const models::InstructionWords& words() const noexcept { return words_; }

 private:
  const tasks::EpisodeSet& episodes_;
  const models::InstructionWords& words_;
  std::vector<RolloutEpisode> walks_;  // by episode
  std::optional<core::ViewFeatures> features_;
  std::unique_ptr<Surroundings> surroundings_;
  std::unique_ptr<RolloutRunner> runner_;
};

/// Runs these episodes with the likeliest choices.
/// \return their trajectories, in their order: one entry per viewpoint, with the direction of
/// arrival
std::vector<tasks::Trajectory> rollout_episodes(const DuetNetwork& network, DuetSplit& split,
                                                std::span<const std::size_t> episodes,
                                                const StepWatcher& watcher = {});

/// Walks all episodes of a split, and writes the files that `options` names. \return a trajectory
/// per episode, in order \throws FileError
std::vector<tasks::Trajectory> rollout_and_write(const DuetNetwork& network, DuetSplit& split,
                                                 const SplitRollout& options,
                                                 const Progress& progress = {});

/// A part of an iteration: one batch, rolled out in one way.
struct WeightedRollout {
  std::span<const RolloutEpisode> episodes;
  DuetRolloutOptions options;  ///< with an expert
  double weight = 1;  ///< of its loss, which is summed over steps and averaged over episodes
};
/// The losses of rollouts, which autograd can follow back.
struct DuetLosses {
  at::Tensor sum;                  ///< weights included; undefined: there is nothing to learn
  double environment_seconds = 0;  ///< as Rollout's, of all rollouts
};
DuetLosses rollout_for_loss(const DuetNetwork& network, RolloutRunner& runner,
                            std::span<const WeightedRollout> rollouts,
                            const StepWatcher& watcher = {});

}  // namespace enfilade::neural::duet
