#include "enfilade/neural/duet/duet_learner.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/neural/detail/batches.h"
#include "enfilade/neural/detail/episode_order.h"
#include "enfilade/neural/duet/duet_split.h"
#include "enfilade/neural/duet/training.h"

namespace enfilade::neural::duet {
namespace {

using models::Feedback;

class DuetLearner : public detail::Learner {
 public:
  DuetLearner(const models::TrainConfig& config, models::InstructionWords words)
      : config_(config),
        words_(std::move(words)),
        network_(duet_sizes(config), config.seed),
        optimizer_(detail::optimizer_of(config, {""})) {}

  void prepare(const TrainingData& data) override {
    const features::FeatureSet* features =
        config_.network.inputs.vision ? &*data.features : nullptr;
    training_.emplace(data.training, words_, config_, features);
    if (config_.evaluate_every > 0) {
      for (const tasks::EpisodeSet& split : data.validation) {
        validation_.push_back(std::make_unique<DuetSplit>(split, words_, config_, features));
      }
    }
    order_.emplace(data.training.episodes.size(), config_.batch_size, config_.seed);
  }

  detail::Update update(std::uint64_t iteration) override {
    const std::vector<WalkEpisode> episodes = training_->batch(order_->batch(iteration));
    const bool alone = config_.feedback == Feedback::kTeacher;
    std::vector<TrainingWalk> walks;
    if (alone || config_.teacher_weight > 0) {
      walks.push_back({episodes, along_the_path(), alone ? 1 : config_.teacher_weight});
    }
    if (!alone) walks.push_back({episodes, on_its_own(), 1});
    for (std::size_t k = 0; k < walks.size(); ++k) {
      walks[k].options.dropout = true;
      walks[k].options.stream = 2 * iteration + k;
    }
    const TrainingStep step = train_once(network_, training_->walker(), walks, optimizer_);
    return {step.loss, step.environment_seconds};
  }

  // Along the annotated paths, without dropout.
  double validation_loss(std::size_t split, std::uint64_t /*iteration*/) override {
    const c10::NoGradGuard no_gradients;
    DuetSplit& prepared = *validation_.at(split);
    const std::size_t total = prepared.episodes().episodes.size();
    double sum = 0;
    detail::for_each_batch(total, config_.batch_size, [&](std::span<const std::size_t> episodes) {
      const Rollout rollout =
          prepared.walker().walk(network_, prepared.batch(episodes), along_the_path());
      if (rollout.loss.defined()) sum += rollout.loss.item<double>();
    });
    return sum / static_cast<double>(total);
  }

  std::vector<tasks::Trajectory> walk(std::size_t split, const models::ModelFiles& files) override {
    DuetSplit& prepared = *validation_.at(split);
    const std::string& name = prepared.episodes().split;
    return walk_and_write(network_, prepared,
                          {config_.batch_size, files.results(name), files.attention(name)});
  }

  Network::State weights() const override { return detail::as_state(network_.weights()); }
  Network::State training_state() const override {
    return detail::as_state(optimizer_.state(network_.weights()));
  }
  void load_training_state(const features::TensorFile& file) override {
    optimizer_.load(network_.weights(), arrays_of(network_.config()), file);
  }

 private:
  WalkOptions along_the_path() const {
    WalkOptions options;
    options.feedback = WalkFeedback::kTeacher;
    options.expert = Expert::kReference;
    options.seed = config_.seed;
    return options;
  }

  WalkOptions on_its_own() const {
    WalkOptions options;
    options.feedback = WalkFeedback::kSample;
    options.expert = config_.map_teacher == models::MapTeacher::kSpl ? Expert::kSpl : Expert::kNdtw;
    options.seed = config_.seed;
    return options;
  }

  const models::TrainConfig& config_;
  models::InstructionWords words_;
  DuetNetwork network_;
  detail::Optimizer optimizer_;
  std::optional<DuetSplit> training_;
  std::vector<std::unique_ptr<DuetSplit>> validation_;
  std::optional<detail::EpisodeOrder> order_;
};

}  // namespace

std::unique_ptr<detail::Learner> make_duet_learner(const models::TrainConfig& config,
                                                   const tasks::Vocabulary& vocabulary) {
  return std::make_unique<DuetLearner>(config, models::InstructionWords(vocabulary));
}

}  // namespace enfilade::neural::duet
