// The panoramic LSTM in training.
#include "enfilade/neural/panoramic/panoramic_learner.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/neural/detail/batches.h"
#include "enfilade/neural/detail/episode_order.h"
#include "enfilade/neural/detail/optimizer.h"
#include "enfilade/neural/panoramic/panoramic_split.h"

namespace enfilade::neural::panoramic {
namespace {

using Clock = std::chrono::steady_clock;
using models::Feedback;
using models::SampledLoss;

// Streams of random numbers of one iteration, so that no two draw the same.
enum Draws : std::uint64_t { kTeacherDropout, kOwnDropout, kOwnChoices, kStreams };

class PanoramicLearner : public detail::Learner {
 public:
  PanoramicLearner(const models::TrainConfig& config, models::InstructionWords words)
      : config_(config),
        words_(std::move(words)),
        network_(panoramic_sizes(config), config.seed),
        optimizer_(detail::optimizer_of(config, {"encoder.", "decoder."})) {}

  void prepare(const TrainingData& data) override {
    const features::FeatureSet* features =
        config_.network.inputs.vision ? &*data.features : nullptr;
    training_.emplace(data.training, words_, config_, features);
    if (config_.evaluate_every > 0) {
      for (const tasks::EpisodeSet& split : data.validation) {
        validation_.push_back(std::make_unique<PanoramicSplit>(split, words_, config_, features));
      }
    }
    order_.emplace(data.training.episodes.size(), config_.batch_size, config_.seed);
  }

  detail::Update update(std::uint64_t iteration) override {
    const auto episodes = order_->batch(iteration);
    at::Tensor loss;
    double data_seconds = 0;
    const auto add = [&](const PanoramicRolloutOptions& options, Draws dropout, double weight) {
      const Clock::time_point begin = Clock::now();
      PanoramicSplit::Batch batch = training_->begin(episodes);
      data_seconds += std::chrono::duration<double>(Clock::now() - begin).count();
      network_.set_dropout(Rng(config_.seed, kStreams * iteration + dropout, 1).next());
      const RolloutLosses losses =
          roll_out(network_, batch.words, batch.walks, training_->images(), options);
      data_seconds += losses.environment_seconds;
      at::Tensor sum = at::zeros({}, at::kFloat);
      if (options.imitate) sum = sum + losses.imitation;
      if (options.reinforce) sum = sum + losses.reinforcement;
      loss = loss.defined() ? loss + weight * sum : weight * sum;
    };
    const bool alone = config_.feedback == Feedback::kTeacher;
    if (alone || config_.teacher_weight > 0) {
      add(behind_teacher(), kTeacherDropout, alone ? 1 : config_.teacher_weight);
    }
    if (!alone) add(on_its_own(iteration), kOwnDropout, 1);
    const double value = loss.item<double>();
    if (!std::isfinite(value)) {
      throw Error(fmt::format("the loss is {}, not a finite number", value));
    }
    loss.backward();
    optimizer_.update(network_.weights());
    return {value, data_seconds};
  }

  // Behind the teacher, without dropout.
  double validation_loss(std::size_t split, std::uint64_t /*iteration*/) override {
    const c10::NoGradGuard no_gradients;
    network_.set_dropout(std::nullopt);
    PanoramicSplit& prepared = *validation_.at(split);
    const std::size_t total = prepared.episodes().episodes.size();
    double sum = 0;
    detail::for_each_batch(total, config_.batch_size, [&](std::span<const std::size_t> episodes) {
      PanoramicSplit::Batch batch = prepared.begin(episodes);
      sum += roll_out(network_, batch.words, batch.walks, prepared.images(), behind_teacher())
                 .imitation.item<double>() *
             static_cast<double>(episodes.size());
    });
    return sum / static_cast<double>(total);
  }

  std::vector<tasks::Trajectory> walk(std::size_t split, const models::ModelFiles& files) override {
    PanoramicSplit& prepared = *validation_.at(split);
    const std::string& name = prepared.episodes().split;
    return walk_and_write(network_, prepared, config_,
                          {config_.batch_size, files.results(name), files.attention(name)});
  }

  Network::State weights() const override { return detail::as_state(network_.weights()); }
  Network::State training_state() const override {
    return detail::as_state(optimizer_.state(network_.weights()));
  }
  void load_training_state(const features::TensorFile& file) override {
    optimizer_.load(network_.weights(), array_specs(network_.config()), file);
  }

 private:
  PanoramicRolloutOptions behind_teacher() const {
    PanoramicRolloutOptions options;
    options.feedback = Feedback::kTeacher;
    options.max_actions = config_.max_steps;
    options.imitate = true;
    return options;
  }

  PanoramicRolloutOptions on_its_own(std::uint64_t iteration) const {
    PanoramicRolloutOptions options;
    options.feedback = Feedback::kSample;
    options.max_actions = config_.max_steps;
    options.imitate = config_.sampled_loss == SampledLoss::kLabels;
    options.reinforce = config_.sampled_loss == SampledLoss::kReinforce;
    options.seed = config_.seed;
    options.stream = kStreams * iteration + kOwnChoices;
    return options;
  }

  const models::TrainConfig& config_;
  models::InstructionWords words_;
  PanoramicNetwork network_;
  detail::Optimizer optimizer_;
  std::optional<PanoramicSplit> training_;
  std::vector<std::unique_ptr<PanoramicSplit>> validation_;
  std::optional<detail::EpisodeOrder> order_;
};

}  // namespace

std::unique_ptr<detail::Learner> make_panoramic_learner(const models::TrainConfig& config,
                                                        const tasks::Vocabulary& vocabulary) {
  return std::make_unique<PanoramicLearner>(config, models::InstructionWords(vocabulary));
}

}  // namespace enfilade::neural::panoramic
