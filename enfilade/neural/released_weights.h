/// \file  Weights that others have trained and released, as model directories.
#pragma once
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/models/model_directory.h"

namespace enfilade::neural {

/// A file of weights, with facts that none of its arrays has.
struct ReleasedWeights {
  std::filesystem::path file;
  /// The words or pieces that the network was trained with: BERT's `vocab.txt`, XLM-R's
  /// `sentencepiece.bpe.model`, or a word a line, as EnvDrop's.
  std::filesystem::path vocabulary;
  std::optional<models::AgentKind> agent = {};  ///< no value: by the arrays' names
  std::int64_t heads = 0;  ///< of DUET's attention; 0: one for 64 columns, as in all published ones
  std::optional<models::Letters> letters =
      {};  ///< no value: cased if the pieces are bert-base-cased's
  models::Subout subout = models::Subout::kMax;  ///< of EnvDrop
  std::optional<std::size_t> max_words = {};     ///< no value: the recipe's
  std::optional<std::size_t> max_steps = {};     ///< likewise
};

/// Result of an import.
struct ImportedWeights {
  models::ModelConfig config;
  std::string family;  ///< "DUET (Chen et al., 2022)"
  std::size_t arrays = 0;
  std::uint64_t parameters = 0;       ///< numbers in them
  std::uint64_t iteration = 0;        ///< of the training; 0: not in the file
  std::vector<std::string> left_out;  ///< "vln_bert.optimizer", "critic: 4 arrays"
  std::filesystem::path vocabulary;   ///< as it is in the directory
};

/// Makes a model directory from a file of weights, of any kind that TensorFile reads: config.json,
/// weights.safetensors, and its vocabulary. The agent is recognised by the names of the arrays, its
/// sizes by their shapes. Known are DUET (also ScaleVLN's, and checkpoints of DUET's pretraining)
/// and EnvDrop's listener. Other settings are those of the published recipe.
/// \throws FileError for files that cannot be read, a folder that is not empty, or a full disk
/// \throws InvalidInput for a file of another network, naming its arrays and the known ones
/// \throws InvalidInput for missing or surplus arrays, naming the first of each, and for a
/// vocabulary of another size
/// \throws ArgumentError if the file is not of `agent`, without a vocabulary (naming a source), and
/// for values out of range
ImportedWeights import_weights(const ReleasedWeights& weights, const std::filesystem::path& folder);

}  // namespace enfilade::neural
