#include "enfilade/neural/duet/duet_learner.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <utility>
#include <vector>

#include "enfilade/neural/detail/batches.h"
#include "enfilade/neural/detail/split_learner.h"
#include "enfilade/neural/duet/duet_split.h"
#include "enfilade/neural/duet/training.h"

namespace enfilade::neural::duet {
namespace {

using models::Feedback;

class DuetLearner : public detail::SplitLearner<DuetNetwork, DuetSplit> {
 public:
  DuetLearner(const models::TrainConfig& config, models::InstructionWords words, c10::Device device)
      : SplitLearner(config, std::move(words), DuetNetwork(duet_sizes(config), config.seed, device),
                     {""}) {}

  void begin_with(const features::TensorFile& weights) override {
    network() = DuetNetwork(network().config(), weights, network().device());
  }

  detail::Update update(std::uint64_t iteration) override {
    double environment_seconds = 0;
    const double loss = learn(iteration, [&](const detail::BatchPart& part) {
      const std::vector<WalkEpisode> episodes = training().batch(part.episodes);
      WalkLosses losses = walk_for_loss(network(), training().walker(), walks_of(episodes, part));
      environment_seconds += losses.environment_seconds;
      return losses.sum;
    });
    return {loss, environment_seconds};
  }

  detail::Evaluated evaluate(std::size_t split, std::uint64_t /*iteration*/,
                             const models::ModelFiles& files) override {
    return detail::Walked{validation_loss(split),
                          walk_and_write(network(), validation(split), walk_of(split, files))};
  }

 private:
  std::vector<TrainingWalk> walks_of(const std::vector<WalkEpisode>& episodes,
                                     const detail::BatchPart& part) const {
    const bool alone = config().feedback == Feedback::kTeacher;
    std::vector<TrainingWalk> walks;
    if (alone || config().teacher_weight > 0) {
      walks.push_back({episodes, along_the_path(), alone ? 1 : config().teacher_weight});
    }
    if (!alone) walks.push_back({episodes, on_its_own(), 1});
    for (std::size_t k = 0; k < walks.size(); ++k) {
      walks[k].options.dropout = true;
      walks[k].options.stream = 2 * part.stream + k;
    }
    return walks;
  }

  // Along the annotated paths, without dropout.
  double validation_loss(std::size_t split) {
    const c10::NoGradGuard no_gradients;
    DuetSplit& prepared = validation(split);
    const std::size_t total = prepared.episodes().episodes.size();
    const double sum = detail::sum_of_batches(
        ranks(), total, config().batch_size, [&](std::span<const std::size_t> episodes) {
          const Rollout rollout =
              prepared.walker().walk(network(), prepared.batch(episodes), along_the_path());
          return rollout.loss.defined() ? rollout.loss.item<double>() : 0;
        });
    return sum / static_cast<double>(total);
  }

  WalkOptions along_the_path() const {
    WalkOptions options;
    options.feedback = WalkFeedback::kTeacher;
    options.expert = Expert::kReference;
    options.seed = config().seed;
    return options;
  }

  WalkOptions on_its_own() const {
    WalkOptions options;
    options.feedback = WalkFeedback::kSample;
    options.expert =
        config().map_teacher == models::MapTeacher::kSpl ? Expert::kSpl : Expert::kNdtw;
    options.seed = config().seed;
    return options;
  }
};

}  // namespace

std::unique_ptr<detail::Learner> make_duet_learner(const models::TrainConfig& config,
                                                   models::InstructionWords words,
                                                   c10::Device device) {
  return std::make_unique<DuetLearner>(config, std::move(words), device);
}

}  // namespace enfilade::neural::duet
