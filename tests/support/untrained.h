/// \file  Models that have learnt nothing: for benchmarks and tests.
#pragma once
#include <filesystem>

#include "enfilade/models/model_directory.h"

namespace enfilade::tests {

/// Writes config.json and weights.safetensors of a panoramic agent or of DUET, with random weights
/// by the training's seed. The vocabulary is the caller's.
/// \throws FileError; ArgumentError for other agents and for impossible sizes
void write_untrained(const models::ModelConfig& config, const std::filesystem::path& folder);

}  // namespace enfilade::tests
