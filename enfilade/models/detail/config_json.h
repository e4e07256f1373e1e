/// \file  The fields of config.json, for writing, reading and comparing them.
#pragma once
#include <nlohmann/json.hpp>

#include "enfilade/core/detail/json.h"
#include "enfilade/models/model_directory.h"

namespace enfilade::models::detail {

nlohmann::ordered_json network_to_json(const TrainConfig& config);  ///< of its agent
nlohmann::ordered_json to_json(const TrainConfig& config);          ///< without its network
nlohmann::ordered_json to_json(const ModelConfig& config);          ///< the whole file

/// Reads a whole file; missing or wrong fields are added to `faults`.
ModelConfig read_config(json::Element root, json::Faults& faults);

}  // namespace enfilade::models::detail
