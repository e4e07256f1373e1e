#include <chrono>
#include <optional>
#include <utility>

#include "enfilade/core/rng.h"
#include "enfilade/neural/detail/episode_order.h"
#include "enfilade/neural/detail/learner.h"
#include "enfilade/neural/evaluation.h"

namespace enfilade::neural::detail {
namespace {

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

class Seq2SeqLearner : public Learner {
 public:
  Seq2SeqLearner(const models::TrainConfig& config, const tasks::Vocabulary& vocabulary,
                 const std::string& device)
      : config_(config), vocabulary_(vocabulary), network_(config.network, config.seed, device) {}

  void prepare(const TrainingData& data) override {
    const std::size_t words = config_.network.max_words;
    const features::FeatureSet* features =
        config_.network.inputs.vision ? &*data.features : nullptr;
    training_.emplace(neural::prepare(data.training, vocabulary_, words, features));
    if (config_.evaluate_every > 0) {
      for (const tasks::EpisodeSet& split : data.validation) {
        validation_.push_back(neural::prepare(split, vocabulary_, words, features));
      }
    }
    order_.emplace(data.training.episodes.size(), config_.batch_size, config_.seed);
    tokens_.resize(config_.batch_size * words);
    environment_.emplace(training_->episodes, training_->view_features(),
                         R2rEnvironmentConfig{config_.batch_size, config_.max_steps,
                                              config_.after_end, config_.forward});
  }

  Update update(std::uint64_t iteration) override {
    const Clock::time_point begin = Clock::now();
    const auto episodes = order_->batch(iteration);
    training_->instructions.gather(episodes, tokens_);
    environment_->start(episodes);
    const Clock::duration before = Clock::now() - begin;
    TimedEnvironment timed(*environment_);
    const RolloutOptions rollout{config_.feedback, config_.max_steps, true, config_.seed,
                                 iteration};
    const InstructionBatch batch{tokens_, config_.batch_size};
    const double loss = network_.rollout_with_gradients(batch, timed, rollout).loss;
    network_.update(config_.adam);
    return {loss / static_cast<double>(config_.max_steps), seconds(before + timed.spent())};
  }

  Evaluated evaluate(std::size_t split, std::uint64_t iteration,
                     const models::ModelFiles& files) override {
    const double loss = validation_loss(split, iteration);
    const PreparedSplit& prepared = validation_.at(split);
    const std::string& name = prepared.episodes.split;
    GreedyWalk walk = walk_greedily(network_, prepared, walk_options());
    write_walk(files.results(name), files.attention(name), walk, prepared, vocabulary_);
    return Walked{loss, std::move(walk.trajectories)};
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
    const LossOptions options{walk_options(),
                              {config_.feedback, config_.max_steps, true, seed, iteration << 20U},
                              config_.after_end,
                              config_.forward};
    return compute_loss(network_, prepared, options);
  }

  WalkOptions walk_options() const { return {config_.batch_size, config_.max_steps}; }

  const models::TrainConfig& config_;
  const tasks::Vocabulary& vocabulary_;
  Network network_;
  std::optional<PreparedSplit> training_;
  std::vector<PreparedSplit> validation_;
  std::optional<EpisodeOrder> order_;
  std::optional<R2rEnvironment> environment_;
  std::vector<std::uint32_t> tokens_;
};

}  // namespace

std::unique_ptr<Learner> make_seq2seq_learner(const models::TrainConfig& config,
                                              const tasks::Vocabulary& vocabulary,
                                              const std::string& device) {
  return std::make_unique<Seq2SeqLearner>(config, vocabulary, device);
}

}  // namespace enfilade::neural::detail
