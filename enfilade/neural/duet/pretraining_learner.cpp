#include "enfilade/neural/duet/duet_learner.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/neural/core/batches.h"
#include "enfilade/neural/core/split_learner.h"
#include "enfilade/neural/duet/duet_split.h"
#include "enfilade/neural/duet/pretraining_tasks.h"

namespace enfilade::neural::duet {
namespace {

// Names of random streams beside those of batches, which are iterations.
constexpr std::uint64_t kTaskStream = ~std::uint64_t{0}, kDropoutStream = kTaskStream - 1;

class PretrainingLearner : public core::SplitLearner<PretrainingNetwork, DuetSplit> {
 public:
  PretrainingLearner(const models::TrainConfig& config, models::InstructionWords words,
                     c10::Device device)
      : SplitLearner(config, std::move(words),
                     PretrainingNetwork(duet_sizes(config), config.seed, device), {""}),
        tasks_(pretraining_tasks(network().config(), config.network.inputs)) {}

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
      Dropout dropout(Rng(seed, kDropoutStream, part.stream).next(), network().config().dropout,
                      network().device());
      return pretraining_loss(network(), guesses, &dropout);
    });
    return {loss, data_seconds};
  }

  core::Evaluated evaluate(std::size_t split, std::uint64_t /*iteration*/,
                           const models::ModelFiles& files) override {
    return core::ValidationRollout{
        validation_loss(split),
        rollout_and_write(network().agent(), validation(split), rollout_of(split, files))};
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

std::unique_ptr<core::Learner> make_pretraining_learner(const models::TrainConfig& config,
                                                        models::InstructionWords words,
                                                        c10::Device device) {
  return std::make_unique<PretrainingLearner>(config, std::move(words), device);
}

}  // namespace enfilade::neural::duet
