#include "enfilade/neural/seq2seq/seq2seq_learner.h"

#include <c10/core/InferenceMode.h>

#include <chrono>
#include <functional>
#include <map>
#include <optional>
#include <utility>

#include "enfilade/core/rng.h"
#include "enfilade/neural/core/episode_order.h"
#include "enfilade/neural/core/gradient_sum.h"
#include "enfilade/neural/seq2seq/evaluation.h"
#include "enfilade/neural/seq2seq/seq2seq.h"

namespace enfilade::neural::seq2seq {
namespace {

using core::BatchParts;
using core::GradientSum;

using Clock = std::chrono::steady_clock;

double seconds(Clock::duration time) { return std::chrono::duration<double>(time).count(); }

// Forwards all calls to an environment and adds up their time.
class TimedEnvironment : public Environment {
 public:
  explicit TimedEnvironment(Environment& inner) : inner_(inner) {}
  Clock::duration spent() const noexcept { return spent_; }

  std::size_t size() const override { return inner_.size(); }
  std::size_t dimensions() const override { return inner_.dimensions(); }
  bool has_teacher() const override { return inner_.has_teacher(); }
  std::span<const std::uint8_t> ended() const override { return inner_.ended(); }
  void observe(const EnvironmentView& out) override {
    const Clock::time_point begin = Clock::now();
    inner_.observe(out);
    spent_ += Clock::now() - begin;
  }
  bool step(std::span<const std::int32_t> actions) override {
    const Clock::time_point begin = Clock::now();
    const bool walking = inner_.step(actions);
    spent_ += Clock::now() - begin;
    return walking;
  }

 private:
  Environment& inner_;
  Clock::duration spent_{};
};

// Where the decoder's weights begin.
constexpr auto kDecoder = static_cast<std::size_t>(Weight::kActionEmbedding);

class Seq2SeqLearner : public core::Learner {
 public:
  Seq2SeqLearner(const models::TrainConfig& config, const tasks::Vocabulary& vocabulary,
                 const std::string& device)
      : config_(config), vocabulary_(vocabulary), network_(config.network, config.seed, device) {}

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
    spent_ = {};
    const auto batch = order_->batch(iteration);
    const double loss = sum_ ? learn_in_parts(batch, iteration) : roll_out(batch, iteration, {});
    network_.update(config_.adam);
    return {loss / static_cast<double>(config_.max_steps), seconds(spent_)};
  }

  core::Evaluated evaluate(std::size_t split, std::uint64_t iteration,
                           const models::ModelFiles& files) override {
    const double loss = validation_loss(split, iteration);
    const PreparedSplit& prepared = validation_.at(split);
    const std::string& name = prepared.episodes.split;
    GreedyRollout walk = rollout_greedily(network_, prepared, batch_options());
    if (ranks_->is_first()) {
      write_rollout(files.results(name), files.attention(name), walk, prepared, vocabulary_);
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

  const Parameters& parameters() { return implementation_of(network_).parameters(); }
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
    const Clock::time_point begin = Clock::now();
    R2rEnvironment& environment = environment_of(episodes.size());
    tokens_.resize(episodes.size() * config_.network.max_words);
    training_->instructions.gather(episodes, tokens_);
    environment.start(episodes);
    spent_ += Clock::now() - begin;
    TimedEnvironment timed(environment);
    const RolloutOptions rollout{config_.feedback, config_.max_steps, true, config_.seed, stream};
    const double loss =
        network_.rollout_with_gradients({tokens_, episodes.size()}, timed, rollout, decoder_done)
            .loss;
    spent_ += timed.spent();
    return loss;
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
  Clock::duration spent_{};  // of an update: in environment, features and instructions
  Ranks* ranks_ = nullptr;
  std::optional<GradientSum> sum_;  // none: one part, one process
};

}  // namespace

std::unique_ptr<core::Learner> make_learner(const models::TrainConfig& config,
                                            const tasks::Vocabulary& vocabulary,
                                            const std::string& device) {
  return std::make_unique<Seq2SeqLearner>(config, vocabulary, device);
}

}  // namespace enfilade::neural::seq2seq
