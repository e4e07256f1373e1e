/// \file  A trained sequence-to-sequence network, loaded from its model directory.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "enfilade/models/model_directory.h"
#include "enfilade/neural/network.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::neural {

/// The content of a model directory, without the checkpoint.
struct Model {
  models::ModelConfig config;
  tasks::Vocabulary vocabulary;
  std::uint64_t iteration = 0;  ///< of the weights
  Network network;
};
/// The files of a model directory. \throws FileError if it is not one, naming the missing file
models::ModelFiles require_model(const std::filesystem::path& folder);

/// Loads a model of seq2seq.
/// \throws FileError for a missing file
/// \throws InvalidInput for damaged files, a vocabulary that has not the network's size, or weights
/// that do not fit
/// \throws ArgumentError for another agent's; Error for a device that is not available
Model load_model(const std::filesystem::path& folder, const std::string& device = "cpu");

}  // namespace enfilade::neural
