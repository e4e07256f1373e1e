#include "enfilade/neural/duet/duet_learner.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <utility>
#include <vector>

#include "enfilade/neural/core/batches.h"
#include "enfilade/neural/core/split_learner.h"
#include "enfilade/neural/duet/duet_split.h"

namespace enfilade::neural::duet {
namespace {

using models::Feedback;

class DuetLearner : public core::SplitLearner<DuetNetwork, DuetSplit> {
 public:
  DuetLearner(const models::TrainConfig& config, models::InstructionWords words, c10::Device device)
      : SplitLearner(config, std::move(words), DuetNetwork(duet_sizes(config), config.seed, device),
                     {""}) {}

  void begin_with(const features::TensorFile& weights) override {
    network() = DuetNetwork(network().config(), weights, network().device());
  }

  core::Update update(std::uint64_t iteration) override {
    double environment_seconds = 0;
    const double loss = learn(iteration, [&](const core::BatchPart& part) {
      const std::vector<RolloutEpisode> episodes = training().batch(part.episodes);
      RolloutLosses losses =
          rollout_for_loss(network(), training().runner(), rollouts_of(episodes, part));
      environment_seconds += losses.environment_seconds;
      return losses.sum;
    });
    return {loss, environment_seconds};
  }

  core::Evaluated evaluate(std::size_t split, std::uint64_t /*iteration*/,
                           const models::ModelFiles& files) override {
    return core::ValidationRollout{
        validation_loss(split),
        rollout_and_write(network(), validation(split), rollout_of(split, files))};
  }

 private:
  std::vector<WeightedRollout> rollouts_of(const std::vector<RolloutEpisode>& episodes,
                                           const core::BatchPart& part) const {
    const bool alone = config().feedback == Feedback::kTeacher;
    std::vector<WeightedRollout> rollouts;
    if (alone || config().teacher_weight > 0) {
      rollouts.push_back({episodes, along_the_path(), alone ? 1 : config().teacher_weight});
    }
    if (!alone) rollouts.push_back({episodes, on_its_own(), 1});
    for (std::size_t k = 0; k < rollouts.size(); ++k) {
      rollouts[k].options.dropout = true;
      rollouts[k].options.stream = 2 * part.stream + k;
    }
    return rollouts;
  }

  // Along the annotated paths, without dropout.
  double validation_loss(std::size_t split) {
    const c10::NoGradGuard no_gradients;
    DuetSplit& prepared = validation(split);
    const std::size_t total = prepared.episodes().episodes.size();
    const double sum = core::sum_of_batches(
        ranks(), total, config().batch_size, [&](std::span<const std::size_t> episodes) {
          const Rollout rollout =
              prepared.runner().run(network(), prepared.batch(episodes), along_the_path());
          return rollout.loss.defined() ? rollout.loss.item<double>() : 0;
        });
    return sum / static_cast<double>(total);
  }

  RolloutOptions along_the_path() const {
    RolloutOptions options;
    options.feedback = RolloutFeedback::kTeacher;
    options.expert = Expert::kReference;
    options.seed = config().seed;
    return options;
  }

  RolloutOptions on_its_own() const {
    RolloutOptions options;
    options.feedback = RolloutFeedback::kSample;
    options.expert =
        config().map_teacher == models::MapTeacher::kSpl ? Expert::kSpl : Expert::kNdtw;
    options.seed = config().seed;
    return options;
  }
};

}  // namespace

RolloutLosses rollout_for_loss(const DuetNetwork& network, RolloutRunner& runner,
                               std::span<const WeightedRollout> rollouts,
                               const StepWatcher& watcher) {
  RolloutLosses result;
  for (const WeightedRollout& part : rollouts) {
    const Rollout rollout = runner.run(network, part.episodes, part.options, watcher);
    result.environment_seconds += rollout.environment_seconds;
    if (!rollout.loss.defined()) continue;
    const at::Tensor loss =
        rollout.loss * (part.weight / static_cast<double>(part.episodes.size()));
    result.sum = result.sum.defined() ? result.sum + loss : loss;
  }
  return result;
}

std::unique_ptr<core::Learner> make_duet_learner(const models::TrainConfig& config,
                                                 models::InstructionWords words,
                                                 c10::Device device) {
  return std::make_unique<DuetLearner>(config, std::move(words), device);
}

}  // namespace enfilade::neural::duet
