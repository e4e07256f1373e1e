/// \file  A model directory: the files of a trained agent.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/features/feature_set.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/models/train_config.h"
#include "enfilade/tasks/annotations.h"
#include "enfilade/tasks/continuous_episodes.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::models {

/// Paths of its files; docs/models.md has the content of each.
struct ModelFiles {
  std::filesystem::path folder;

  std::filesystem::path config() const { return folder / "config.json"; }
  std::filesystem::path vocabulary() const { return folder / "vocabulary.txt"; }
  /// The file of the words or pieces that the agent reads: `vocabulary.txt`, `pieces.txt` (BERT's)
  /// or `pieces.model` (XLM-R's).
  std::filesystem::path text(TextKind kind) const;
  std::filesystem::path weights() const { return folder / "weights.safetensors"; }
  std::filesystem::path checkpoint() const { return folder / "checkpoint.safetensors"; }
  std::filesystem::path previous_checkpoint() const {
    return folder / "checkpoint.previous.safetensors";
  }
  std::filesystem::path log() const { return folder / "log.jsonl"; }
  std::filesystem::path lock() const { return folder / "training.lock"; }
  /// `results/<split>.json`
  std::filesystem::path results(const std::string& split) const {
    return folder / "results" / (split + ".json");
  }
  /// `walks/02/<scan>.safetensors`: DAgger data of a continuous agent. \param set from 1
  std::filesystem::path walks(std::size_t set, std::string_view scan) const;
  /// The weights of its picture encoder: `encoder`, whatever their format.
  std::filesystem::path encoder() const { return folder / "encoder"; }
  /// `results/<split>.attention.json`
  std::filesystem::path attention(const std::string& split) const {
    return folder / "results" / (split + ".attention.json");
  }
};

/// Writes one of its files, and its folder; a link in its place is replaced. \throws FileError
void write_file(const ModelFiles& files, const std::filesystem::path& file,
                std::string_view content);

/// The files of a model directory. \throws FileError if it is none, naming the file that is missing
ModelFiles require_model(const std::filesystem::path& folder);

// --- config.json ---

/// Hashes of the data that a model was trained on, to detect other data: 16 hex digits of XXH3.
/// They are of the content, not of files: white space is ignored.
struct DataFingerprint {
  std::map<std::string, std::string> annotations;  ///< by split
  std::map<std::string, std::string> graphs;       ///< by scan
  std::optional<features::FeatureInfo> features;   ///< none if the agent does not see

  void add(const tasks::Annotations& split);           ///< the annotations of a split
  void add(const tasks::ContinuousEpisodes& split);    ///< the episodes of a split
  void add_graphs(const tasks::EpisodeSet& episodes);  ///< of all scans that these are in
};

/// Differences between the data of training and the present data, as warnings naming the split,
/// scan or field. Only of splits, scans and features that are in both. `file` is the model's, for
/// messages.
std::vector<Diagnostic> differences(const DataFingerprint& trained, const DataFingerprint& now,
                                    const std::string& file);

/// The content of config.json.
struct ModelConfig {
  TrainConfig training;  ///< network.vocabulary and network.features are set
  DataFingerprint data;
};
/// The text of config.json.
std::string to_json(const ModelConfig& config);
/// Reads config.json. \throws FileError; InvalidInput listing its faults (up to 1000) with their
/// JSON paths
ModelConfig load_model_config(const std::filesystem::path& file);

/// Reads vocabulary.txt. \throws FileError; InvalidInput, also if its size is not the network's
tasks::Vocabulary load_vocabulary(const ModelFiles& files, const NetworkConfig& network);

/// Reads the words or pieces of an agent that chooses among viewpoints, from the file of its kind
/// of text.
/// \throws FileError; InvalidInput, also if their number is not the network's
InstructionWords load_instruction_words(const ModelFiles& files, const TrainConfig& training);

/// `features` if the model uses vision, else null.
/// \throws ArgumentError if it does and there are none, or their size is not the network's
const features::FeatureSet* usable_features(const ModelConfig& config,
                                            const features::FeatureSet* features);

// --- states ---

/// Writes a network's arrays with their iteration and a hash, by which a reader detects damage.
/// Atomic. \throws FileError
void write_state(const std::filesystem::path& file, std::span<const features::NamedArray> arrays,
                 std::uint64_t iteration);
/// A file that write_state() wrote.
struct StateFile {
  features::TensorFile file;
  std::uint64_t iteration = 0;
};
/// Opens a file of weights or a checkpoint. \throws FileError; InvalidInput for another file, or a
/// damaged one
StateFile open_state(const std::filesystem::path& file);

/// Writes checkpoint and weights, and keeps the previous checkpoint. There is a complete checkpoint
/// at any time, even if the process is killed or the disk is full. \throws FileError
void write_checkpoint(const ModelFiles& files, std::span<const features::NamedArray> checkpoint,
                      std::span<const features::NamedArray> weights, std::uint64_t iteration);

}  // namespace enfilade::models
