#include "enfilade/neural/panoramic/speaker_learner.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/neural/detail/episode_order.h"
#include "enfilade/neural/detail/optimizer.h"
#include "enfilade/neural/panoramic/speaker_split.h"

namespace enfilade::neural::panoramic {
namespace {

class SpeakerLearner : public detail::Learner {
 public:
  SpeakerLearner(const models::TrainConfig& config, models::InstructionWords words)
      : config_(config),
        words_(std::move(words)),
        network_(speaker_sizes(config), config.seed),
        optimizer_(detail::optimizer_of(config, {"encoder.", "decoder."})) {}

  void prepare(const TrainingData& data) override {
    const features::FeatureSet* const features =
        config_.network.inputs.vision ? &*data.features : nullptr;
    training_.emplace(data.training, words_, config_, features);
    if (config_.evaluate_every > 0) {
      for (const tasks::EpisodeSet& split : data.validation) {
        validation_.push_back(std::make_unique<SpeakerSplit>(split, words_, config_, features));
      }
    }
    order_.emplace(data.training.episodes.size(), config_.batch_size, config_.seed);
  }

  detail::Update update(std::uint64_t iteration) override {
    constexpr std::uint64_t kOfDropout = 1;
    const auto begin = std::chrono::steady_clock::now();
    const auto episodes = order_->batch(iteration);
    const PathBatch paths = training_->see(training_->paths_of(episodes));
    const at::Tensor sentences = training_->sentences(episodes);
    const double data_seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    network_.set_dropout(Rng(config_.seed, iteration, kOfDropout).next());
    const TellingLoss loss = telling_loss(network_, paths, sentences);
    const double value = loss.mean.item<double>();
    if (!std::isfinite(value)) {
      throw Error(fmt::format("the loss is {}, not a finite number", value));
    }
    loss.mean.backward();
    optimizer_.update(network_.weights());
    return {value, data_seconds};
  }

  double validation_loss(std::size_t split, std::uint64_t /*iteration*/) override {
    return telling(split).loss;
  }
  std::vector<tasks::Trajectory> walk(std::size_t /*split*/,
                                      const models::ModelFiles& /*files*/) override {
    EN_CHECK(false);  // tell() is called in its place
    return {};
  }
  std::optional<models::TellingRecord> tell(std::size_t split) override { return telling(split); }

  Network::State weights() const override { return detail::as_state(network_.weights()); }
  Network::State training_state() const override {
    return detail::as_state(optimizer_.state(network_.weights()));
  }
  void load_training_state(const features::TensorFile& file) override {
    optimizer_.load(network_.weights(), array_specs(network_.config()), file);
  }

 private:
  models::TellingRecord telling(std::size_t split) {
    return score_telling(network_, *validation_.at(split), config_.batch_size);
  }

  const models::TrainConfig& config_;
  models::InstructionWords words_;
  SpeakerNetwork network_;
  detail::Optimizer optimizer_;
  std::optional<SpeakerSplit> training_;
  std::vector<std::unique_ptr<SpeakerSplit>> validation_;
  std::optional<detail::EpisodeOrder> order_;
};

}  // namespace

std::unique_ptr<detail::Learner> make_speaker_learner(const models::TrainConfig& config,
                                                      const tasks::Vocabulary& vocabulary) {
  return std::make_unique<SpeakerLearner>(config, models::InstructionWords(vocabulary));
}

}  // namespace enfilade::neural::panoramic
