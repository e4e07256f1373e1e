// The panoramic LSTM in training.
#include "enfilade/neural/panoramic/panoramic_learner.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <chrono>
#include <memory>
#include <optional>

#include "enfilade/core/rng.h"
#include "enfilade/neural/core/batches.h"
#include "enfilade/neural/core/split_learner.h"
#include "enfilade/neural/panoramic/panoramic_split.h"

namespace enfilade::neural::panoramic {
namespace {

using Clock = std::chrono::steady_clock;
using models::Feedback;
using models::SampledLoss;

// Streams of random numbers of one part of a batch, so that no two draw the same.
enum Draws : std::uint64_t { kTeacherDropout, kOwnDropout, kOwnChoices, kStreams };

class PanoramicLearner : public core::SplitLearner<PanoramicNetwork, PanoramicSplit> {
 public:
  PanoramicLearner(const models::TrainConfig& config, const tasks::Vocabulary& vocabulary,
                   c10::Device device)
      : SplitLearner(config, models::InstructionWords(vocabulary),
                     PanoramicNetwork(panoramic_sizes(config), config.seed, device),
                     {"encoder.", "decoder."}) {}

  core::Update update(std::uint64_t iteration) override {
    double data_seconds = 0;
    const double loss =
        learn(iteration, [&](const core::BatchPart& part) { return loss_of(part, data_seconds); });
    return {loss, data_seconds};
  }

  core::Evaluated evaluate(std::size_t split, std::uint64_t /*iteration*/,
                           const models::ModelFiles& files) override {
    return core::ValidationRollout{
        validation_loss(split),
        rollout_and_write(network(), validation(split), rollout_of(split, files))};
  }

 private:
  at::Tensor loss_of(const core::BatchPart& part, double& data_seconds) {
    at::Tensor loss;
    const auto add = [&](PanoramicRolloutOptions options, Draws dropout, double weight) {
      options.resident = training().resident(network().device());
      const Clock::time_point begin = Clock::now();
      PanoramicSplit::Batch walks = training().begin(part.episodes);
      data_seconds += std::chrono::duration<double>(Clock::now() - begin).count();
      network().set_dropout(Rng(config().seed, kStreams * part.stream + dropout, 1).next());
      const RolloutLosses losses =
          roll_out(network(), walks.words, walks.walks, training().images(), options);
      data_seconds += losses.environment_seconds;
      at::Tensor sum;
      if (options.imitate) sum = losses.imitation;
      if (options.reinforce) {
        sum = sum.defined() ? sum + losses.reinforcement : losses.reinforcement;
      }
      loss = loss.defined() ? loss + weight * sum : weight * sum;
    };
    const bool alone = config().feedback == Feedback::kTeacher;
    if (alone || config().teacher_weight > 0) {
      add(behind_teacher(), kTeacherDropout, alone ? 1 : config().teacher_weight);
    }
    if (!alone) add(on_its_own(part.stream), kOwnDropout, 1);
    return loss;
  }

  // Behind the teacher, without dropout.
  double validation_loss(std::size_t split) {
    const c10::NoGradGuard no_gradients;
    network().set_dropout(std::nullopt);
    PanoramicSplit& prepared = validation(split);
    PanoramicRolloutOptions options = behind_teacher();
    options.resident = prepared.resident(network().device());
    const std::size_t total = prepared.episodes().episodes.size();
    const double sum = core::sum_of_batches(
        ranks(), total, config().batch_size, [&](std::span<const std::size_t> episodes) {
          PanoramicSplit::Batch walks = prepared.begin(episodes);
          return roll_out(network(), walks.words, walks.walks, prepared.images(), options)
                     .imitation.item<double>() *
                 static_cast<double>(episodes.size());
        });
    return sum / static_cast<double>(total);
  }

  PanoramicRolloutOptions behind_teacher() const {
    PanoramicRolloutOptions options;
    options.feedback = Feedback::kTeacher;
    options.max_actions = config().max_steps;
    options.imitate = true;
    return options;
  }

  PanoramicRolloutOptions on_its_own(std::uint64_t stream) const {
    PanoramicRolloutOptions options;
    options.feedback = Feedback::kSample;
    options.max_actions = config().max_steps;
    options.imitate = config().sampled_loss == SampledLoss::kLabels;
    options.reinforce = config().sampled_loss == SampledLoss::kReinforce;
    options.seed = config().seed;
    options.stream = kStreams * stream + kOwnChoices;
    return options;
  }
};

}  // namespace

std::unique_ptr<core::Learner> make_panoramic_learner(const models::TrainConfig& config,
                                                      const tasks::Vocabulary& vocabulary,
                                                      c10::Device device) {
  return std::make_unique<PanoramicLearner>(config, vocabulary, device);
}

}  // namespace enfilade::neural::panoramic
