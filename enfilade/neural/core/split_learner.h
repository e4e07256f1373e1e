/// \file  Shared part of the learners of networks on libtorch's autograd.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/models/instruction_words.h"
#include "enfilade/neural/core/episode_order.h"
#include "enfilade/neural/core/learner.h"
#include "enfilade/neural/core/optimizer.h"
#include "enfilade/neural/core/parted_learning.h"
#include "enfilade/neural/trained_agent.h"

namespace enfilade::neural::core {

/// Owns a network, its optimizer, and the splits. A kind of agent adds update(), validation_loss(),
/// evaluate().
/// \tparam Network has weights() by name
/// \tparam Split is made of episodes, words, the config and features
template <class Network, class Split>
class SplitLearner : public Learner {
 public:
  /// \param config outlives *this \param parts as OptimizerConfig::parts
  SplitLearner(const models::TrainConfig& config, models::InstructionWords words, Network network,
               std::vector<std::string> parts)
      : config_(config),
        words_(std::move(words)),
        network_(std::move(network)),
        optimizer_(optimizer_of(config, std::move(parts))) {}

  void prepare(const TrainingData& data, Ranks& ranks) override {
    ranks_ = &ranks;
    const GraphData& own = data.graph();
    const features::FeatureSet* const features =
        config_.network.inputs.vision ? &*own.features : nullptr;
    training_.emplace(own.training, words_, config_, features);
    if (config_.evaluate_every > 0) {
      for (const tasks::EpisodeSet& split : own.validation) {
        validation_.push_back(std::make_unique<Split>(split, words_, config_, features));
      }
    }
    order_.emplace(own.training.episodes.size(), config_.batch_size, config_.seed);
    learning_.emplace(ranks, config_.parts.value_or(1), network_.weights(), optimizer_);
  }

  State weights() const override { return as_state(network_.weights()); }
  State training_state() const override { return as_state(optimizer_.state(network_.weights())); }
  void load_training_state(const features::TensorFile& file) override {
    optimizer_.load(network_.weights(), file);
  }

 protected:
  const models::TrainConfig& config() const noexcept { return config_; }
  const models::InstructionWords& words() const noexcept { return words_; }
  Network& network() noexcept { return network_; }
  Split& training() { return *training_; }
  Split& validation(std::size_t split) { return *validation_.at(split); }
  /// Those that train together.
  Ranks& ranks() noexcept { return *ranks_; }
  /// One update of the weights, by the losses of the parts of an iteration's batch. \return the
  /// loss \throws as PartedLearning::learn()
  double learn(std::uint64_t iteration, const LossOf& loss_of) {
    return learning_->learn(order_->batch(iteration), iteration, loss_of);
  }
  /// How a validation split is walked, and what is written of it.
  SplitRollout rollout_of(std::size_t split, const models::ModelFiles& files) {
    const std::string& name = validation(split).episodes().split;
    return {config_.batch_size, files.results(name), files.attention(name), ranks_};
  }

 private:
  const models::TrainConfig& config_;
  models::InstructionWords words_;
  Network network_;
  Optimizer optimizer_;
  std::optional<Split> training_;
  std::vector<std::unique_ptr<Split>> validation_;
  std::optional<EpisodeOrder> order_;
  Ranks* ranks_ = nullptr;
  std::optional<PartedLearning> learning_;
};

}  // namespace enfilade::neural::core
