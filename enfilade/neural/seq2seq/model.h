/// \file  A trained sequence-to-sequence network, loaded from its model directory.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "enfilade/models/model_directory.h"
#include "enfilade/neural/seq2seq/network.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::neural::seq2seq {

/// The content of a model directory, without the checkpoint.
struct Model {
  models::ModelConfig config;
  tasks::Vocabulary vocabulary;
  std::uint64_t iteration = 0;  ///< of the weights
  Network network;
};
/// Loads a model of seq2seq.
/// \throws FileError for a missing file
/// \throws InvalidInput for damaged files, a vocabulary of another size than the network's, or
/// weights that do not fit
/// \throws ArgumentError for another agent's model
/// \throws Error for a device that is not available
Model load_model(const std::filesystem::path& folder, const std::string& device = "cpu");

}  // namespace enfilade::neural::seq2seq
