/// \file  A trained speaker: it describes paths in words, for agents to be trained with
/// (back-translation).
#pragma once
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/models/training_log.h"
#include "enfilade/tasks/annotations.h"

namespace enfilade::neural {

/// How paths are described.
struct SpeakOptions {
  std::size_t batch_size = 64;   ///< paths at once
  std::size_t most_words = 120;  ///< per instruction; EnvDrop's number
  /// Seed of words that are drawn by their probabilities. No value: the likeliest ones.
  std::optional<std::uint64_t> drawn = {};
  /// Share of the features' columns that are missing, the same all over a batch; [0, 1).
  double environmental_dropout = 0;
  std::uint64_t environment_seed = 1;  ///< of these columns
};

/// A speaker from its model directory, without dropout. On the CPU. One thread at a time.
class Speaker {
 public:
  /// \throws FileError for a missing file; InvalidInput for damaged files, or weights or a
  /// vocabulary that do not fit; ArgumentError for another agent's model
  explicit Speaker(const std::filesystem::path& folder);

  const models::ModelConfig& config() const noexcept;
  std::uint64_t iteration() const noexcept;  ///< of the weights

  /// How well it predicts the instructions of a split, and its own ones of the same paths.
  /// \param features null if the speaker does not see
  /// \throws ArgumentError for hidden goals, no instructions, or features of another size or none
  /// where it sees; InvalidInput for viewpoints that have none
  models::SpeakerRecord score(const tasks::EpisodeSet& episodes,
                              const features::FeatureSet* features, std::size_t batch_size = 64,
                              const Progress& progress = {});

  /// An instruction for each of EpisodeSet::paths, in their order; its episodes are ignored. The
  /// same options give the same texts.
  /// \throws as score()
  std::vector<std::string> describe(const tasks::EpisodeSet& paths,
                                    const features::FeatureSet* features,
                                    const SpeakOptions& options, const Progress& progress = {});

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;  // of all copies
};

}  // namespace enfilade::neural
