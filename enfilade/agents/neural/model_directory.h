/// \file  A trained agent as a folder.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "enfilade/agents/neural/data_fingerprint.h"
#include "enfilade/agents/neural/network.h"
#include "enfilade/agents/neural/train_config.h"
#include "enfilade/r2r/tokenizer.h"

namespace enfilade::agents::neural {

/// The names of its files; docs/agents.md says what is in each. A plain value.
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

/// Everything but the checkpoint.
struct Model {
  ModelConfig config;
  r2r::Vocabulary vocabulary;
  std::uint64_t iteration = 0;  ///< that the weights are of
  Network network;
};
/// \throws FileError, naming what makes a model where the folder has none; InvalidInput for broken
/// files, a vocabulary of another size than the network's, weights that do not fit or whose bytes
/// are not those that were written; Error for a device that is not there
Model load_model(const std::filesystem::path& folder, const std::string& device = "cpu");

/// What to walk with: `features` if the model sees, else nothing.
/// \throws ArgumentError if it sees and has no features, or such of another size
const FeatureSet* usable_features(const ModelConfig& config, const FeatureSet* features);

/// Writes a network's arrays with their hash and the iteration they are of, so that a reader knows
/// whether they are what was written. Atomic. \throws FileError
void write_state(const std::filesystem::path& file, const Network::State& state,
                 std::uint64_t iteration);
/// A file that write_state() wrote. \throws FileError; InvalidInput for any other, or a broken one
struct StateFile {
  TensorFile file;
  std::uint64_t iteration = 0;
};
StateFile open_state(const std::filesystem::path& file);

/// Writes checkpoint and weights; keeps the checkpoint before. At every moment there is a whole
/// checkpoint, also if the process is killed or the disk is full. \throws FileError
void write_checkpoint(const ModelFiles& files, const Network& network, std::uint64_t iteration);

}  // namespace enfilade::agents::neural
