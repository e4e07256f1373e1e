#include "enfilade/neural/speaker.h"

#include <fmt/format.h>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/neural/speaker/speaker_split.h"

namespace enfilade::neural {
namespace {

models::ModelConfig speaker_config(const std::filesystem::path& folder,
                                   const models::ModelFiles& files) {
  models::ModelConfig config = models::load_model_config(files.config());
  if (config.training.agent != models::AgentKind::kSpeaker) {
    throw ArgumentError(fmt::format("{}: an agent {}, not a speaker", folder.string(),
                                    to_string(config.training.agent)));
  }
  return config;
}

}  // namespace

struct Speaker::Impl {
  Impl(const std::filesystem::path& folder, const models::ModelFiles& files)
      : config(speaker_config(folder, files)),
        words(models::load_instruction_words(files, config.training)),
        state(models::open_state(files.weights())),
        network(speaker_sizes(config.training), state.file) {}

  speaker::SpeakerSplit split(const tasks::EpisodeSet& episodes,
                              const features::FeatureSet* features) const {
    return {episodes, words, config.training, models::usable_features(config, features)};
  }

  models::ModelConfig config;
  models::InstructionWords words;
  models::StateFile state;
  speaker::SpeakerNetwork network;
};

Speaker::Speaker(const std::filesystem::path& folder)
    : impl_(std::make_unique<Impl>(folder, models::require_model(folder))) {}
Speaker::~Speaker() = default;
Speaker::Speaker(Speaker&&) noexcept = default;
Speaker& Speaker::operator=(Speaker&&) noexcept = default;

const models::ModelConfig& Speaker::config() const noexcept { return impl_->config; }
std::uint64_t Speaker::iteration() const noexcept { return impl_->state.iteration; }

models::SpeakerRecord Speaker::score(const tasks::EpisodeSet& episodes,
                                     const features::FeatureSet* features, std::size_t batch_size,
                                     const Progress& progress) {
  speaker::SpeakerSplit split = impl_->split(episodes, features);
  models::SpeakerRecord record =
      speaker::score_speaker(impl_->network, split, batch_size, nullptr, progress);
  record.iteration = iteration();
  return record;
}

std::vector<std::string> Speaker::describe(const tasks::EpisodeSet& paths,
                                           const features::FeatureSet* features,
                                           const SpeakOptions& options, const Progress& progress) {
  speaker::SpeakerSplit split = impl_->split(paths, features);
  speaker::DescribeSplitOptions own;
  own.batch_size = options.batch_size;
  own.most_words = options.most_words;
  if (options.drawn) {
    own.choice = speaker::WordChoice::kDrawn;
    own.seed = *options.drawn;
  }
  if (options.environmental_dropout != 0) {
    own.environment = speaker::EnvironmentalDropoutOptions{options.environmental_dropout,
                                                           speaker::SameEnvironment::kBatch,
                                                           options.environment_seed, 0};
  }
  std::vector<std::string> texts;
  for (const auto& words : speaker::describe_split(impl_->network, split, own, progress)) {
    texts.push_back(speaker::join_words(words));
  }
  return texts;
}

}  // namespace enfilade::neural
