/// \file  A split as the speaker describes it.
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "enfilade/agents/panorama.h"
#include "enfilade/core/progress.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/models/train_config.h"
#include "enfilade/models/training_log.h"
#include "enfilade/neural/core/view_features.h"
#include "enfilade/neural/ranks.h"
#include "enfilade/neural/speaker/environmental_dropout.h"
#include "enfilade/neural/speaker/speaker_decoding.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::neural::speaker {

/// Paths with their instructions as ids, and the features of their buildings. One thread at a time.
class SpeakerSplit {
 public:
  /// `episodes` and `words` have to outlive *this. \param features null without vision
  /// \throws as ViewFeatures; ArgumentError for episodes whose goals are hidden
  SpeakerSplit(const tasks::EpisodeSet& episodes, const models::InstructionWords& words,
               const models::TrainConfig& config, const features::FeatureSet* features);
  SpeakerSplit(const SpeakerSplit&) = delete;
  SpeakerSplit& operator=(const SpeakerSplit&) = delete;

  const tasks::EpisodeSet& episodes() const noexcept { return episodes_; }
  const models::InstructionWords& words() const noexcept { return words_; }
  /// The views along paths. \param paths indices into EpisodeSet::paths
  /// \param environment columns that are missing everywhere; no value: none is missing
  PathBatch see(std::span<const std::size_t> paths,
                const std::optional<EnvironmentalDropoutOptions>& environment = std::nullopt);
  /// The paths of episodes, and their instructions for instruction_loss().
  std::vector<std::size_t> paths_of(std::span<const std::size_t> episodes) const;
  at::Tensor sentences(std::span<const std::size_t> episodes) const;  ///< likewise

 private:
  const tasks::EpisodeSet& episodes_;
  const models::InstructionWords& words_;
  SpeakerConfig sizes_;
  std::vector<std::vector<std::int64_t>> ids_;  // by episode
  std::optional<core::ViewFeatures> features_;
  ImageSource images_;
  agents::PanoramaCache panoramas_;
};

/// How paths are described.
struct DescribeSplitOptions {
  std::size_t batch_size = 64;
  WordChoice choice = WordChoice::kLikeliest;
  std::size_t most_words = 120;  ///< per instruction
  std::uint64_t seed = 1;        ///< of draws, whose stream is a path's index
  /// Columns that are missing; `stream` is that of the batch.
  std::optional<EnvironmentalDropoutOptions> environment = {};
  Ranks* ranks = nullptr;  ///< as SplitRollout::ranks
};

/// An instruction a path of the split, in their order, as words. Without dropout but that of the
/// environment.
std::vector<std::vector<std::string>> describe_split(SpeakerNetwork& network, SpeakerSplit& split,
                                                     const DescribeSplitOptions& options,
                                                     const Progress& progress = {});

/// Describes all paths of a split, each word the likeliest, and predicts the words of all its
/// instructions. The iteration is left to the caller. Paths without an instruction do not count.
/// \param ranks as SplitRollout::ranks
/// \throws ArgumentError for a split without instructions
models::SpeakerRecord score_speaker(SpeakerNetwork& network, SpeakerSplit& split,
                                    std::size_t batch_size, Ranks* ranks = nullptr,
                                    const Progress& progress = {});

}  // namespace enfilade::neural::speaker
