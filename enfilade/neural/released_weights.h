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

/// A file of weights, and what no array in it says.
struct ReleasedWeights {
  std::filesystem::path file;
  /// The words or pieces that the network was trained with: BERT's `vocab.txt`, XLM-R's
  /// `sentencepiece.bpe.model`, or a word a line, as EnvDrop's.
  std::filesystem::path vocabulary;
  std::optional<models::AgentKind> agent = {};  ///< no value: what the arrays' names say
  std::int64_t heads = 0;  ///< of DUET's attention; 0: one for 64 columns, as in all published ones
  std::optional<models::Letters> letters =
      {};  ///< no value: cased if the pieces are bert-base-cased's
  models::Subout subout = models::Subout::kMax;  ///< of EnvDrop
  std::optional<std::size_t> max_words = {};     ///< no value: the recipe's
  std::optional<std::size_t> max_steps = {};     ///< likewise
};

/// What was found.
struct ImportedWeights {
  models::ModelConfig config;
  std::string family;  ///< "DUET (Chen et al., 2022)"
  std::size_t arrays = 0;
  std::uint64_t parameters = 0;       ///< numbers in them
  std::uint64_t iteration = 0;        ///< of the training; 0: the file does not say
  std::vector<std::string> left_out;  ///< "vln_bert.optimizer", "critic: 4 arrays"
  std::filesystem::path vocabulary;   ///< as it is in the directory
};

/// Reads a file of weights, of any kind that TensorFile reads, and makes the directory of a model
/// of it: config.json, weights.safetensors, and its vocabulary. The agent is recognised by the
/// names of the arrays, its sizes by their shapes: DUET (also ScaleVLN's, and checkpoints of DUET's
/// pretraining) and EnvDrop's listener. What cannot be found out is as in the published recipe.
/// \throws FileError for files that cannot be read, a folder that is not empty or a disk without
/// room; InvalidInput for a file of another network, naming what it has and what is known, or with
/// arrays that are missing or surplus, naming the first of each, and for a vocabulary of another
/// size; ArgumentError where the file is of another agent than `agent`, without a vocabulary
/// (saying where it is to be had), and for values out of range
ImportedWeights import_weights(const ReleasedWeights& weights, const std::filesystem::path& folder);

}  // namespace enfilade::neural
