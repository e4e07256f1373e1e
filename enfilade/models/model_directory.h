/// \file  A trained agent as a folder.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "enfilade/models/data_fingerprint.h"
#include "enfilade/models/train_config.h"
#include "enfilade/r2r/tokenizer.h"

namespace enfilade::models {

/// The names of its files; docs/models.md says what is in each. A plain value.
struct ModelFiles {
  std::filesystem::path folder;

  std::filesystem::path config() const { return folder / "config.json"; }
  std::filesystem::path vocabulary() const { return folder / "vocabulary.txt"; }
  std::filesystem::path weights() const { return folder / "weights.safetensors"; }
  std::filesystem::path checkpoint() const { return folder / "checkpoint.safetensors"; }
  std::filesystem::path previous_checkpoint() const {
    return folder / "checkpoint.previous.safetensors";
  }
  std::filesystem::path log() const { return folder / "log.jsonl"; }
  std::filesystem::path lock() const { return folder / "training.lock"; }
  /// Files of a split, below results/.
  std::filesystem::path results(std::string_view split) const;
  std::filesystem::path attention(std::string_view split) const;
};

/// config.json.
struct ModelConfig {
  TrainConfig training;  ///< with network.vocabulary and network.features
  DataFingerprint data;
};
std::string to_json(const ModelConfig& config);
/// \throws FileError; InvalidInput listing every fault with its JSON path
ModelConfig load_model_config(const std::filesystem::path& file);

/// \throws FileError; InvalidInput, also for another size than the network's
r2r::Vocabulary load_vocabulary(const ModelFiles& files, const NetworkConfig& network);

/// What to walk with: `features` if the model sees, else nothing.
/// \throws ArgumentError if it sees and has no features, or such of another size
const features::FeatureSet* usable_features(const ModelConfig& config,
                                            const features::FeatureSet* features);

/// Writes a network's arrays with their hash and the iteration they are of, so that a reader knows
/// whether they are what was written. Atomic. \throws FileError
void write_state(const std::filesystem::path& file, std::span<const features::NamedArray> arrays,
                 std::uint64_t iteration);
/// A file that write_state() wrote. \throws FileError; InvalidInput for any other, or a broken one
struct StateFile {
  features::TensorFile file;
  std::uint64_t iteration = 0;
};
StateFile open_state(const std::filesystem::path& file);

/// Writes checkpoint and weights; keeps the checkpoint before. At every moment there is a whole
/// checkpoint, also if the process is killed or the disk is full. \throws FileError
void write_checkpoint(const ModelFiles& files, std::span<const features::NamedArray> checkpoint,
                      std::span<const features::NamedArray> weights, std::uint64_t iteration);

}  // namespace enfilade::models
