#include "enfilade/neural/core/learner.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <chrono>

#include "enfilade/core/rng.h"
#include "enfilade/neural/duet/duet_split.h"
#include "enfilade/neural/duet/pretraining_tasks.h"

namespace enfilade::neural::duet {
namespace {

using models::Feedback;

class DuetLearner : public core::SplitLearner<DuetNetwork, DuetSplit> {
 public:
  explicit DuetLearner(const core::LearnerParts& parts)
      : SplitLearner(parts, DuetNetwork(duet_sizes(parts.config), parts.config.seed, parts.device),
                     {""}) {}

  void begin_with(const features::TensorFile& weights) override {
    network() = DuetNetwork(network().config(), weights, network().device());
  }

  core::Update update(std::uint64_t iteration) override {
    double environment_seconds = 0;
    const double loss = learn(iteration, [&](const core::BatchPart& part) {
      const std::vector<RolloutEpisode> episodes = training().batch(part.episodes);
      DuetLosses losses =
          rollout_for_loss(network(), training().runner(), rollouts_of(episodes, part));
      environment_seconds += losses.environment_seconds;
      return losses.sum;
    });
    return {loss, environment_seconds};
  }

  core::Evaluated evaluate(std::size_t split, std::uint64_t /*iteration*/,
                           const models::ModelFiles& files) override {
    return validated(split, validation_loss(split), network(), files);
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
    return core::mean_of_batches(ranks(), prepared.episodes().episodes.size(), config().batch_size,
                                 [&](std::span<const std::size_t> episodes) {
                                   const Rollout rollout = prepared.runner().run(
                                       network(), prepared.batch(episodes), along_the_path());
                                   return rollout.loss.defined() ? rollout.loss.item<double>() : 0;
                                 });
  }

  DuetRolloutOptions along_the_path() const {
    return {
        .feedback = RolloutFeedback::kTeacher, .expert = Expert::kReference, .seed = config().seed};
  }

  DuetRolloutOptions on_its_own() const {
    return {
        .feedback = RolloutFeedback::kSample,
        .expert = config().map_teacher == models::MapTeacher::kSpl ? Expert::kSpl : Expert::kNdtw,
        .seed = config().seed};
  }
};

// Names of random streams beside those of batches, which are iterations.
constexpr std::uint64_t kTaskStream = ~std::uint64_t{0}, kDropoutStream = kTaskStream - 1;

class PretrainingLearner : public core::SplitLearner<PretrainingNetwork, DuetSplit> {
 public:
  explicit PretrainingLearner(const core::LearnerParts& parts)
      : SplitLearner(parts,
                     PretrainingNetwork(duet_sizes(parts.config), parts.config.seed, parts.device),
                     {""}),
        tasks_(pretraining_tasks(network().config(), parts.config.network.inputs)) {}

  void begin_with(const features::TensorFile& weights) override {
    network() = PretrainingNetwork(network().config(), weights, config().seed, network().device());
  }

  core::Update update(std::uint64_t iteration) override {
    const std::uint64_t seed = config().seed;
    const PretrainingTask task = tasks_[Rng(seed, kTaskStream, iteration).below(tasks_.size())];
    double data_seconds = 0;
    const double loss = learn(iteration, [&](const core::BatchPart& part) {
      const auto begin = std::chrono::steady_clock::now();
      PretrainingDraws draws;
      draws.seed = seed;
      draws.stream = part.stream;
      const PretrainingBatch guesses =
          batch_of(training(), training().batch(part.episodes), task, draws);
      const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - begin;
      data_seconds += spent.count();
      RateDropout dropout(Rng(seed, kDropoutStream, part.stream).next(), network().config().dropout,
                          network().device());
      return pretraining_loss(network(), guesses, &dropout);
    });
    return {loss, data_seconds};
  }

  core::Evaluated evaluate(std::size_t split, std::uint64_t /*iteration*/,
                           const models::ModelFiles& files) override {
    return validated(split, validation_loss(split), network().agent(), files);
  }

 private:
  PretrainingBatch batch_of(DuetSplit& split, const std::vector<RolloutEpisode>& episodes,
                            PretrainingTask task, const PretrainingDraws& draws) {
    return pretraining_batch(split.runner(), network().config(), words(), episodes, task, draws);
  }

  // Without dropout; the gaps are the same after each iteration.
  double validation_loss(std::size_t split) {
    const c10::NoGradGuard no_gradients;
    double sum = 0;
    for (const PretrainingTask task : tasks_) sum += validation_loss(validation(split), task);
    return sum / static_cast<double>(tasks_.size());
  }

  double validation_loss(DuetSplit& split, PretrainingTask task) {
    const std::string& name = split.episodes().split;
    PretrainingDraws draws;
    draws.seed = config().seed ^ stream_of(name.data(), name.size());
    const std::size_t total = split.episodes().episodes.size();
    std::size_t guessed = 0;
    const auto loss_of = [&](std::span<const std::size_t> which) -> std::optional<double> {
      draws.stream = which.front();
      const at::Tensor loss =
          pretraining_loss(network(), batch_of(split, split.batch(which), task, draws));
      if (!loss.defined()) return std::nullopt;
      return loss.item<double>();
    };
    double sum = 0;
    std::size_t first = 0;
    for (const std::string& packed : core::share_batches(
             ranks(), total, config().batch_size,
             [&](std::span<const std::size_t> which) { return core::packed(loss_of(which)); })) {
      const std::size_t count = std::min(config().batch_size, total - first);
      first += count;
      const auto loss = core::unpacked<std::optional<double>>(packed);
      if (!loss) continue;
      sum += *loss * static_cast<double>(count);
      guessed += count;
    }
    return guessed > 0 ? sum / static_cast<double>(guessed) : 0;
  }

  std::vector<PretrainingTask> tasks_;
};

}  // namespace

DuetLosses rollout_for_loss(const DuetNetwork& network, RolloutRunner& runner,
                            std::span<const WeightedRollout> rollouts, const StepWatcher& watcher) {
  DuetLosses result;
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

}  // namespace enfilade::neural::duet

namespace enfilade::neural::core {

std::unique_ptr<Learner> make_duet_learner(const LearnerParts& parts) {
  return std::make_unique<duet::DuetLearner>(parts);
}

std::unique_ptr<Learner> make_pretraining_learner(const LearnerParts& parts) {
  return std::make_unique<duet::PretrainingLearner>(parts);
}

}  // namespace enfilade::neural::core
