#include "enfilade/neural/speaker/speaker_learner.h"

#include <ATen/ATen.h>
#include <chrono>
#include <memory>

#include "enfilade/core/rng.h"
#include "enfilade/neural/core/split_learner.h"
#include "enfilade/neural/speaker/speaker_split.h"

namespace enfilade::neural::speaker {
namespace {

class SpeakerLearner : public core::SplitLearner<SpeakerNetwork, SpeakerSplit> {
 public:
  SpeakerLearner(const models::TrainConfig& config, const tasks::Vocabulary& vocabulary,
                 c10::Device device)
      : SplitLearner(config, models::InstructionWords(vocabulary),
                     SpeakerNetwork(speaker_sizes(config), config.seed, device),
                     {"encoder.", "decoder."}) {}

  core::Update update(std::uint64_t iteration) override {
    constexpr std::uint64_t kOfDropout = 1;
    double data_seconds = 0;
    const double loss = learn(iteration, [&](const core::BatchPart& part) {
      const auto begin = std::chrono::steady_clock::now();
      const PathBatch paths = training().see(training().paths_of(part.episodes));
      const at::Tensor sentences = training().sentences(part.episodes);
      data_seconds +=
          std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      network().set_dropout(Rng(config().seed, part.stream, kOfDropout).next());
      return instruction_loss(network(), paths, sentences).mean;
    });
    return {loss, data_seconds};
  }

  core::Evaluated evaluate(std::size_t split, std::uint64_t /*iteration*/,
                           const models::ModelFiles& /*files*/) override {
    return score_speaker(network(), validation(split), config().batch_size, &ranks());
  }
};

}  // namespace

std::unique_ptr<core::Learner> make_speaker_learner(const models::TrainConfig& config,
                                                    const tasks::Vocabulary& vocabulary,
                                                    c10::Device device) {
  return std::make_unique<SpeakerLearner>(config, vocabulary, device);
}

}  // namespace enfilade::neural::speaker
