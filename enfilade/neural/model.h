/// \file  A trained agent, loaded from its model directory.
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>

#include "enfilade/models/model_directory.h"
#include "enfilade/neural/network.h"
#include "enfilade/r2r/tokenizer.h"

namespace enfilade::neural {

/// Everything but the checkpoint.
struct Model {
  models::ModelConfig config;
  r2r::Vocabulary vocabulary;
  std::uint64_t iteration = 0;  ///< that the weights are of
  Network network;
};
/// \throws FileError, naming what makes a model where the folder has none; InvalidInput for broken
/// files, a vocabulary of another size than the network's, weights that do not fit or whose bytes
/// are not those that were written; Error for a device that is not there
Model load_model(const std::filesystem::path& folder, const std::string& device = "cpu");

}  // namespace enfilade::neural
