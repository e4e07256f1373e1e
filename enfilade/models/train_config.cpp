#include "enfilade/models/train_config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <array>
#include <nlohmann/json.hpp>

#include "enfilade/core/errors.h"
#include "enfilade/models/detail/config_json.h"

namespace enfilade::models {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<std::string_view, 4> kInputs{"none", "language", "vision", "language+vision"};

// What weights do not depend on.
bool is_free(std::string_view field) {
  return field == "iterations" || field == "validation" || field == "evaluate_every" ||
         field == "checkpoint_every";
}

void check_positive(const char* name, std::size_t value) {
  if (value > 0) return;
  throw ArgumentError(fmt::format("{}: 0, at least 1 is needed", name));
}

void check_adam(const AdamConfig& adam) {
  check_range("learning_rate", adam.learning_rate, 0, 1);
  check_range("beta1", adam.beta1, 0, 1);
  check_range("beta2", adam.beta2, 0, 1);
  check_range("epsilon", adam.epsilon, 0, 1);
  check_range("weight_decay", adam.weight_decay, 0, 1);
}

}  // namespace

std::size_t paper_iterations(Feedback feedback) noexcept {
  return feedback == Feedback::kTeacher ? 5'000 : 20'000;
}

std::string_view to_string(const Inputs& inputs) noexcept {
  return kInputs[(inputs.language ? 1U : 0U) + (inputs.vision ? 2U : 0U)];
}

Inputs parse_inputs(std::string_view name) {
  for (std::size_t i = 0; i < kInputs.size(); ++i) {
    if (kInputs[i] == name) return {(i & 1U) != 0, (i & 2U) != 0};
  }
  throw ArgumentError(
      fmt::format("inputs {:?}: one of {} is allowed", name, fmt::join(kInputs, ", ")));
}

std::string_view to_string(AfterEnd value) noexcept {
  return value == AfterEnd::kWalksOn ? "walks-on" : "stays";
}

std::string_view to_string(ForwardTo value) noexcept {
  return value == ForwardTo::kNearest ? "nearest" : "intended";
}

AfterEnd parse_after_end(std::string_view name) {
  if (name == to_string(AfterEnd::kWalksOn)) return AfterEnd::kWalksOn;
  if (name == to_string(AfterEnd::kStays)) return AfterEnd::kStays;
  throw ArgumentError(fmt::format("after end {:?}: walks-on or stays is allowed", name));
}

ForwardTo parse_forward_to(std::string_view name) {
  if (name == to_string(ForwardTo::kNearest)) return ForwardTo::kNearest;
  if (name == to_string(ForwardTo::kIntended)) return ForwardTo::kIntended;
  throw ArgumentError(fmt::format("forward {:?}: nearest or intended is allowed", name));
}

Feedback parse_feedback(std::string_view name) {
  if (name == "student") return Feedback::kSample;
  if (name == "teacher") return Feedback::kTeacher;
  throw ArgumentError(fmt::format("feedback {:?}: student or teacher is allowed", name));
}

void validate(const TrainConfig& config) {
  NetworkConfig network = config.network;
  network.vocabulary = 4;  // it, and features, come from the data
  if (network.features == 0) network.features = 1;
  validate(network);
  check_adam(config.adam);
  if (config.feedback == Feedback::kArgmax) {
    throw ArgumentError("feedback argmax: student or teacher is allowed in training");
  }
  check_positive("batch_size", config.batch_size);
  check_positive("max_steps", config.max_steps);
  check_positive("iterations", config.iterations);
  check_positive("checkpoint_every", config.checkpoint_every);
  check_positive("splits", config.splits.size());
  if (config.buildings) check_positive("buildings", *config.buildings);
}

std::vector<std::string> differences(const TrainConfig& there, const TrainConfig& here) {
  std::vector<std::string> found;
  const auto compare = [&found](const Json& a, const Json& b) {
    const auto text = [](const Json& config, const std::string& name) {
      return config.contains(name) ? config.at(name).dump() : std::string("none");
    };
    Json names = a;
    names.update(b);  // either may lack what it has no value for
    for (const auto& [name, value] : names.items()) {
      const std::string was = text(a, name), is = text(b, name);
      if (is_free(name) || was == is) continue;
      found.push_back(fmt::format("{}: {}, not {}", name, was, is));
    }
  };
  compare(detail::to_json(there.network), detail::to_json(here.network));
  compare(detail::to_json(there), detail::to_json(here));
  return found;
}

}  // namespace enfilade::models
