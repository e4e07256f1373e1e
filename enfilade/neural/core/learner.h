/// \file  Interface of an agent in training: its updates, its rollouts, its state.
#pragma once
#include <c10/core/Device.h>
#include <fmt/format.h>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/features/tensor_file.h"
#include "enfilade/models/instruction_words.h"
#include "enfilade/models/model_directory.h"
#include "enfilade/models/training_log.h"
#include "enfilade/neural/core/batches.h"
#include "enfilade/neural/core/gradient_sum.h"
#include "enfilade/neural/core/optimizer.h"
#include "enfilade/neural/core/weights.h"
#include "enfilade/neural/ranks.h"
#include "enfilade/neural/trained_agent.h"
#include "enfilade/neural/training_data.h"
#include "enfilade/tasks/results.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::neural {
struct GatheringProgress;  // continuous_agent.h
}  // namespace enfilade::neural

namespace enfilade::neural::core {

/// Result of one update.
struct Update {
  double loss = 0;          ///< as the log has it
  double data_seconds = 0;  ///< in environment, features and instructions
};

/// How an agent that walks does in a split.
struct ValidationRollout {
  double loss = 0;
  std::vector<tasks::Trajectory> trajectories;  ///< greedy, one per episode
};
/// Validation record of an agent on graphs, of a speaker or of a continuous agent; the last two
/// without the iteration.
using Evaluated = std::variant<ValidationRollout, models::SpeakerRecord, models::EvaluationRecord>;

/// One kind of agent in training. train() owns directory, log, checkpoints and the order of work, a
/// learner all else. All random numbers are named by the config's seed and the iteration, so that
/// the state is only parameters and moments. One thread at a time.
class Learner {
 public:
  virtual ~Learner() = default;
  /// Encodes instructions and looks up features. Called once, before the functions below, with the
  /// weights in place.
  /// \param ranks the processes that train together; outlive *this
  /// \throws ArgumentError if they cannot share the parts of a batch
  virtual void prepare(const TrainingData& data, Ranks& ranks) = 0;
  /// One update of the weights. \param iteration updates before it
  virtual Update update(std::uint64_t iteration) = 0;
  /// Validates the agent on split `split` after `iteration` iterations. Rank 0 writes the results
  /// below `files`. No effect on the weights.
  /// \pre split < TrainingData::validation.size()
  virtual Evaluated evaluate(std::size_t split, std::uint64_t iteration,
                             const models::ModelFiles& files) = 0;

  /// Takes the weights of another model, ahead of the first update. \throws ArgumentError for an
  /// agent that cannot; InvalidInput as load_training_state()
  virtual void begin_with(const features::TensorFile& /*weights*/) {
    throw ArgumentError("this agent begins with random weights alone");
  }

  virtual SavedState weights() const = 0;
  virtual SavedState training_state() const = 0;
  /// \throws InvalidInput naming every missing, surplus and wrong-shaped array
  virtual void load_training_state(const features::TensorFile& file) = 0;
};

/// For data to train on or validate with. \throws ArgumentError if goals of the split are hidden
template <class Episodes>
void require_goals(const Episodes& set) {
  if (!goals_hidden(set)) return;
  throw ArgumentError(fmt::format(
      "split {}: its goals are hidden, so it cannot be trained on or validated with", set.split));
}

/// Leaves only the episodes in the first `most` scans of `places`.
/// \param scan_of of a place and of an episode \throws ArgumentError for fewer scans
template <class Episodes, class Places, class ScanOf>
void keep_buildings(Episodes& set, const Places& places, std::size_t most, const ScanOf& scan_of) {
  std::vector<decltype(scan_of(places.front()))> scans;
  for (const auto& place : places) {
    const auto scan = scan_of(place);
    if (std::ranges::find(scans, scan) == scans.end()) scans.push_back(scan);
  }
  if (scans.size() < most) {
    throw ArgumentError(
        fmt::format("buildings: {}, but split {} has {}", most, set.split, scans.size()));
  }
  scans.resize(most);
  std::erase_if(set.episodes, [&](const auto& episode) {
    return std::ranges::find(scans, scan_of(episode)) == scans.end();
  });
}

/// What a learner is made of; `config` and `words` outlive it.
struct LearnerParts {
  const models::TrainConfig& config;
  const models::InstructionWords& words;
  c10::Device device;
  models::ModelFiles files = {};  ///< of the model that is trained
  /// Told of each set of rollouts while it is gathered; may be empty.
  std::function<void(const GatheringProgress&)> gathering = {};
};

// The learners of the agents, each defined in its agent's room.

/// The sequence-to-sequence agent. \pre there is a vocabulary \throws as seq2seq::Network
std::unique_ptr<Learner> make_seq2seq_learner(const LearnerParts& parts);

/// The panoramic LSTM: imitation, student-forcing, advantage actor-critic. An iteration is a
/// teacher-forced rollout, one of the agent's own, or both, of the same episodes, by
/// TrainConfig::feedback, teacher_weight and sampled_loss. EnvDrop's is an own rollout with rewards
/// and a fifth of the teacher's loss. \throws as PanoramicNetwork
std::unique_ptr<Learner> make_panoramic_learner(const LearnerParts& parts);

/// The speaker. An iteration is a batch of instructions with their paths. Its loss is the mean
/// cross-entropy of their words, each after the true ones before it. \throws as SpeakerNetwork
std::unique_ptr<Learner> make_speaker_learner(const LearnerParts& parts);

/// The continuous agent: DAgger (Ross, Gordon, Bagnell 2011). Before the first update that needs a
/// set of rollouts it gathers them, into `walks/` of the model directory, a file per building:
/// `walks/02/home0001.safetensors`. Files of the same weights stay, so that a killed training
/// continues.
std::unique_ptr<Learner> make_continuous_learner(const LearnerParts& parts);

/// DUET. An iteration has one or both of two rollouts of the same episodes. One follows the
/// annotated path. The other is the agent's own, with a teacher that names a node of its map.
/// TrainConfig::feedback, teacher_weight and map_teacher choose. The published iteration is an own
/// rollout and a fifth of the annotated one's loss. \throws as DuetNetwork
std::unique_ptr<Learner> make_duet_learner(const LearnerParts& parts);

/// Its pretraining. An iteration is one batch of one of the network's tasks, drawn with equal
/// chances. Validation losses are means over the tasks; walks are the fine-tuned agent's.
/// \pre config.stage is kPretrain \throws as DuetNetwork
std::unique_ptr<Learner> make_pretraining_learner(const LearnerParts& parts);

/// Owns a network and its optimizer.
/// \tparam Network has weights() by name
template <class Network>
class NetworkLearner : public Learner {
 public:
  /// \param clipped as OptimizerConfig::parts
  NetworkLearner(const LearnerParts& parts, Network network, std::vector<std::string> clipped)
      : config_(parts.config),
        words_(parts.words),
        network_(std::move(network)),
        optimizer_(optimizer_of(config_, std::move(clipped))) {}

  void prepare(const TrainingData& /*data*/, Ranks& ranks) override {
    ranks_ = &ranks;
    learning_.emplace(ranks, config_.parts.value_or(1), network_.weights(), optimizer_);
  }

  SavedState weights() const override { return as_state(network_.weights()); }
  SavedState training_state() const override {
    return as_state(optimizer_.state(network_.weights()));
  }
  void load_training_state(const features::TensorFile& file) override {
    optimizer_.load(network_.weights(), file);
  }

 protected:
  const models::TrainConfig& config() const noexcept { return config_; }
  const models::InstructionWords& words() const noexcept { return words_; }
  Network& network() noexcept { return network_; }
  const Network& network() const noexcept { return network_; }
  /// Those that train together.
  Ranks& ranks() noexcept { return *ranks_; }
  PartedLearning& learning() noexcept { return *learning_; }

 private:
  const models::TrainConfig& config_;
  const models::InstructionWords& words_;
  Network network_;
  WeightOptimizer optimizer_;
  Ranks* ranks_ = nullptr;
  std::optional<PartedLearning> learning_;
};

/// Owns the splits too. A kind of agent adds update() and evaluate().
/// \tparam Split is made of episodes, words, the config and features
template <class Network, class Split>
class SplitLearner : public NetworkLearner<Network> {
 public:
  using NetworkLearner<Network>::NetworkLearner;

  void prepare(const TrainingData& data, Ranks& ranks) override {
    NetworkLearner<Network>::prepare(data, ranks);
    const models::TrainConfig& config = this->config();
    const GraphData& own = data.graph();
    const features::FeatureSet* const features =
        config.network.inputs.vision ? &*own.features : nullptr;
    training_.emplace(own.training, this->words(), config, features);
    if (config.evaluate_every > 0) {
      for (const tasks::EpisodeSet& split : own.validation) {
        validation_.push_back(std::make_unique<Split>(split, this->words(), config, features));
      }
    }
    order_.emplace(own.training.episodes.size(), config.batch_size, config.seed);
  }

 protected:
  Split& training() { return *training_; }
  Split& validation(std::size_t split) { return *validation_.at(split); }
  /// One update of the weights, by the losses of the parts of an iteration's batch. \return the
  /// loss \throws as PartedLearning::learn()
  double learn(std::uint64_t iteration, const LossOf& loss_of) {
    return this->learning().learn(order_->batch(iteration), iteration, loss_of);
  }
  /// Walks a validation split with the agent's network, and writes what is shown of it.
  template <class Agent>
  Evaluated validated(std::size_t split, double loss, Agent& agent,
                      const models::ModelFiles& files) {
    const std::string& name = validation(split).episodes().split;
    return ValidationRollout{
        loss, rollout_and_write(agent, validation(split),
                                SplitRollout{this->config().batch_size, files.results(name),
                                             files.attention(name), &this->ranks(), files.folder})};
  }

 private:
  std::optional<Split> training_;
  std::vector<std::unique_ptr<Split>> validation_;
  std::optional<EpisodeOrder> order_;
};

}  // namespace enfilade::neural::core
