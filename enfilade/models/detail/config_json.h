/// \file  The fields of config.json, listed once, for writing, reading and comparing them.
#pragma once
#include <concepts>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/detail/json.h"
#include "enfilade/models/data_fingerprint.h"
#include "enfilade/models/train_config.h"

namespace enfilade::models::detail {

/// Calls visitor(name, field) for each field. `Config` is a NetworkConfig, const or not.
template <class Config, class Visitor>
void visit_network(Config& config, Visitor&& visitor) {
  visitor("vocabulary", config.vocabulary);
  visitor("max_words", config.max_words);
  visitor("word_embedding", config.word_embedding);
  visitor("hidden", config.hidden);
  visitor("action_embedding", config.action_embedding);
  visitor("features", config.features);
  visitor("dropout", config.dropout);
  visitor("inputs", config.inputs);
}

/// The same for a TrainConfig, without its network.
template <class Config, class Visitor>
void visit_training(Config& config, Visitor&& visitor) {
  visitor("feedback", config.feedback);
  visitor("iterations", config.iterations);
  visitor("batch_size", config.batch_size);
  visitor("max_steps", config.max_steps);
  visitor("after_end", config.after_end);
  visitor("forward", config.forward);
  visitor("seed", config.seed);
  visitor("splits", config.splits);
  visitor("least_count", config.least_count);
  visitor("learning_rate", config.adam.learning_rate);
  visitor("beta1", config.adam.beta1);
  visitor("beta2", config.adam.beta2);
  visitor("epsilon", config.adam.epsilon);
  visitor("weight_decay", config.adam.weight_decay);
  visitor("validation", config.validation);
  visitor("evaluate_every", config.evaluate_every);
  visitor("checkpoint_every", config.checkpoint_every);
}

/// The same for the features that a model was trained on.
template <class Info, class Visitor>
void visit_features(Info& info, Visitor&& visitor) {
  visitor("encoder", info.encoder);
  visitor("preprocessing", info.preprocessing);
  visitor("weights", info.weights);
  visitor("dimensions", info.dimensions);
  visitor("camera", info.camera);
}

nlohmann::ordered_json to_json(const NetworkConfig& config);
nlohmann::ordered_json to_json(const TrainConfig& config);  ///< without its network
nlohmann::ordered_json to_json(const DataFingerprint& data);

/// Reads an object; what is missing or wrong is added to `faults`.
void read(json::Element element, const json::Path& path, json::Faults& faults,
          NetworkConfig& config);
void read(json::Element element, const json::Path& path, json::Faults& faults, TrainConfig& config);
void read(json::Element element, const json::Path& path, json::Faults& faults,
          DataFingerprint& data);

}  // namespace enfilade::models::detail
