/// \file  A split for the panoramic agent.
#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/agents/panorama.h"
#include "enfilade/core/progress.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/models/train_config.h"
#include "enfilade/neural/core/view_features.h"
#include "enfilade/neural/panoramic/panoramic_rollout.h"
#include "enfilade/neural/trained_agent.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::neural::panoramic {

/// Episodes with their instructions as ids, and the features of their buildings. One thread at a
/// time.
class PanoramicSplit {
 public:
  /// `episodes` and `words` have to outlive *this. \param features null without vision
  /// \throws as ViewFeatures
  PanoramicSplit(const tasks::EpisodeSet& episodes, const models::InstructionWords& words,
                 const models::TrainConfig& config, const features::FeatureSet* features);
  PanoramicSplit(const PanoramicSplit&) = delete;
  PanoramicSplit& operator=(const PanoramicSplit&) = delete;

  /// Episodes at their starts. Rows are by falling number of words, as the encoder requires.
  struct Batch {
    std::vector<std::size_t> places;  ///< per row, index into the given episodes
    WordBatch words;
    std::vector<PanoramicEpisode> walks;
  };
  /// \param episodes indices into EpisodeSet::episodes
  Batch begin(std::span<const std::size_t> episodes);

  const tasks::EpisodeSet& episodes() const noexcept { return episodes_; }
  const ImageSource& images() const noexcept { return images_; }
  /// Likewise, on a card; null for the CPU, or if the agent does not see. The device is the first
  /// one asked for.
  core::ResidentViews* resident(c10::Device device);
  std::size_t max_actions() const noexcept { return max_actions_; }  ///< choices of an episode
  std::span<const std::int64_t> words(std::size_t episode) const { return words_[episode]; }
  const models::InstructionWords& vocabulary() const noexcept { return vocabulary_; }

 private:
  const tasks::EpisodeSet& episodes_;
  const models::InstructionWords& vocabulary_;
  std::size_t max_actions_;
  std::vector<std::vector<std::int64_t>> words_;  // by episode
  std::optional<core::ViewFeatures> features_;
  ImageSource images_;
  std::optional<core::ResidentViews> resident_;
  agents::PanoramaCache panoramas_;
};

/// Called at each step of each batch.
using BatchObserver =
    std::function<void(const PanoramicSplit::Batch& batch, const PanoramicStep& step)>;

/// Walks these episodes, each with the likeliest choices, up to split.max_actions() of them.
/// \return their trajectories, in their order
std::vector<tasks::Trajectory> rollout_episodes(PanoramicNetwork& network, PanoramicSplit& split,
                                                std::span<const std::size_t> episodes,
                                                const BatchObserver& observer = {});

/// Walks all episodes of a split, and writes the files that `options` names. \return a trajectory
/// per episode, in order \throws FileError
std::vector<tasks::Trajectory> rollout_and_write(PanoramicNetwork& network, PanoramicSplit& split,
                                                 const SplitRollout& options,
                                                 const Progress& progress = {});

}  // namespace enfilade::neural::panoramic
