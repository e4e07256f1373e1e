#include "enfilade/neural/core/learner.h"

#include <c10/core/InferenceMode.h>
#include <chrono>
#include <map>

#include "enfilade/core/rng.h"
#include "enfilade/neural/seq2seq/evaluation.h"
#include "enfilade/neural/seq2seq/seq2seq.h"

namespace enfilade::neural::seq2seq {
namespace {

using core::BatchParts;
using core::GradientSum;

// Where the decoder's weights begin.
constexpr auto kDecoder = static_cast<std::size_t>(Weight::kActionEmbedding);

class Seq2SeqLearner : public core::Learner {
 public:
  explicit Seq2SeqLearner(const core::LearnerParts& parts)
      : config_(parts.config),
        vocabulary_(*parts.words.vocabulary()),
        network_(config_.network, config_.seed, parts.device.str()) {}

  void prepare(const TrainingData& data, Ranks& ranks) override {
    ranks_ = &ranks;
    const GraphData& own = data.graph();
    const std::size_t words = config_.network.max_words;
    const features::FeatureSet* features = config_.network.inputs.vision ? &*own.features : nullptr;
    training_.emplace(seq2seq::prepare(own.training, vocabulary_, words, features));
    if (config_.evaluate_every > 0) {
      for (const tasks::EpisodeSet& split : own.validation) {
        validation_.push_back(seq2seq::prepare(split, vocabulary_, words, features));
      }
    }
    order_.emplace(own.training.episodes.size(), config_.batch_size, config_.seed);
    const BatchParts parts = core::share_parts(config_.parts.value_or(1), ranks);
    if (parts.parts == 1) return;
    std::vector<std::int64_t> sizes;
    for (const WeightInfo& info : parameters().infos()) sizes.push_back(info.elements);
    sum_.emplace(ranks, parts, std::move(sizes));
  }

  core::Update update(std::uint64_t iteration) override {
    spent_ = 0;
    const auto batch = order_->batch(iteration);
    const double loss = sum_ ? learn_in_parts(batch, iteration) : roll_out(batch, iteration, {});
    network_.update(config_.adam);
    return {loss / static_cast<double>(config_.max_steps), spent_};
  }

  core::Evaluated evaluate(std::size_t split, std::uint64_t iteration,
                           const models::ModelFiles& files) override {
    const double loss = validation_loss(split, iteration);
    const PreparedSplit& prepared = validation_.at(split);
    const std::string& name = prepared.episodes.split;
    GreedyRollout walk = rollout_greedily(network_, prepared, batch_options());
    if (ranks_->is_first()) {
      write_rollout({.results = files.results(name),
                     .attention = files.attention(name),
                     .model = files.folder},
                    walk, prepared, vocabulary_);
    }
    return core::ValidationRollout{loss, std::move(walk.trajectories)};
  }

  Network::State weights() const override { return network_.weights(); }
  Network::State training_state() const override { return network_.training_state(); }
  void load_training_state(const features::TensorFile& file) override {
    network_.load_training_state(file);
  }

 private:
  double validation_loss(std::size_t split, std::uint64_t iteration) {
    const PreparedSplit& prepared = validation_.at(split);
    const std::string& name = prepared.episodes.split;
    // Other random numbers than training's; streams apart from those of other iterations.
    const std::uint64_t seed = config_.seed ^ stream_of(name.data(), name.size());
    const LossOptions options{batch_options(),
                              {config_.feedback, config_.max_steps, true, seed, iteration << 20U},
                              config_.after_end,
                              config_.forward};
    return compute_loss(network_, prepared, options);
  }

  BatchOptions batch_options() const { return {config_.batch_size, config_.max_steps, ranks_}; }

  const Parameters& parameters() { return network_.parameters(); }
  at::Tensor gradient(std::size_t weight) {
    return parameters().view(parameters().flat_gradients, weight);
  }

  // Parts of a batch have one of two sizes.
  R2rEnvironment& environment_of(std::size_t size) {
    std::unique_ptr<R2rEnvironment>& environment = environments_[size];
    if (!environment) {
      environment = std::make_unique<R2rEnvironment>(
          training_->episodes, training_->view_features(),
          R2rEnvironmentConfig{size, config_.max_steps, config_.after_end, config_.forward});
    }
    return *environment;
  }

  // Leaves the gradients. \return the loss
  double roll_out(std::span<const std::size_t> episodes, std::uint64_t stream,
                  const std::function<void()>& decoder_done) {
    const auto begin = std::chrono::steady_clock::now();
    R2rEnvironment& environment = environment_of(episodes.size());
    tokens_.resize(episodes.size() * config_.network.max_words);
    training_->instructions.gather(episodes, tokens_);
    environment.start(episodes);
    spent_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const RolloutOptions rollout{config_.feedback, config_.max_steps, true, config_.seed, stream};
    const RolloutResult result = network_.rollout_with_gradients(
        {tokens_, episodes.size()}, environment, rollout, decoder_done);
    spent_ += result.environment_seconds;
    return result.loss;
  }

  double learn_in_parts(std::span<const std::size_t> batch, std::uint64_t iteration) {
    const BatchParts& own = sum_->parts();
    for (std::size_t k = own.first; k < own.first + own.count; ++k) {
      const auto episodes = core::part_of(batch, k, own.parts);
      sum_->begin_part(static_cast<double>(episodes.size()) / static_cast<double>(batch.size()));
      std::vector<at::Tensor> gradients(kWeights);
      double loss = 0;
      if (!episodes.empty()) {
        loss = roll_out(episodes, iteration * own.parts + k, [this] {
          for (std::size_t i = kDecoder; i < kWeights; ++i) sum_->ready(i, gradient(i));
        });
        for (std::size_t i = 0; i < kWeights; ++i) gradients[i] = gradient(i);
      }
      sum_->end_part(gradients, loss);
    }
    const GradientSum::Sums sums = sum_->finish();
    const c10::InferenceMode guard;  // as the network's memory was made in it
    for (std::size_t i = 0; i < kWeights; ++i) {
      if (sums.gradients[i].defined()) gradient(i).copy_(sums.gradients[i].view_as(gradient(i)));
    }
    return sums.loss;
  }

  const models::TrainConfig& config_;
  const tasks::Vocabulary& vocabulary_;
  Network network_;
  std::optional<PreparedSplit> training_;
  std::vector<PreparedSplit> validation_;
  std::optional<core::EpisodeOrder> order_;
  std::map<std::size_t, std::unique_ptr<R2rEnvironment>> environments_;  // by number of episodes
  std::vector<std::uint32_t> tokens_;
  double spent_ = 0;  // seconds of an update in environment, features and instructions
  Ranks* ranks_ = nullptr;
  std::optional<GradientSum> sum_;  // none: one part, one process
};

}  // namespace
}  // namespace enfilade::neural::seq2seq

namespace enfilade::neural::core {

std::unique_ptr<Learner> make_seq2seq_learner(const LearnerParts& parts) {
  return std::make_unique<seq2seq::Seq2SeqLearner>(parts);
}

}  // namespace enfilade::neural::core
