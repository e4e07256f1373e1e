#include "enfilade/neural/panoramic/speaker_split.h"

#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/neural/detail/batches.h"
#include "enfilade/neural/panoramic/bleu.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::neural::panoramic {
namespace {

void check_known(const tasks::EpisodeSet& episodes) {
  for (const tasks::ReferencePath& path : episodes.paths) {
    if (!goal_hidden(path)) continue;
    throw ArgumentError(
        fmt::format("split {}: its goals are hidden, so its paths cannot be told", episodes.split));
  }
}

}  // namespace

SpeakerSplit::SpeakerSplit(const tasks::EpisodeSet& episodes, const models::InstructionWords& words,
                           const models::TrainConfig& config, const features::FeatureSet* features)
    : episodes_(episodes),
      words_(words),
      sizes_(speaker_sizes(config)),
      panoramas_(episodes.graphs) {
  check_known(episodes);
  for (const tasks::Episode& episode : episodes.episodes) {
    ids_.push_back(words.encode(episode, config.network.max_words));
  }
  if (features != nullptr) features_.emplace(*features, episodes);
  images_ = [this](graph::Location location, std::uint32_t view, std::span<float> out) {
    if (features_) features_->copy(location.scan, location.viewpoint, view, out);
  };
}

PathBatch SpeakerSplit::see(std::span<const std::size_t> paths,
                            const std::optional<EnvironmentalDropoutOptions>& environment) {
  std::vector<PathToTell> told;
  for (const std::size_t at : paths) {
    const tasks::ReferencePath& path = episodes_.paths[at];
    told.push_back({path.scan, path.heading, path.viewpoints});
  }
  const ImageSource images = environment ? drop_environment(images_, *environment) : images_;
  PathBatch batch = see_paths(told, sizes_, images, panoramas_, *episodes_.graphs);
  if (environment) batch.dropped = FeaturesDropped::kBefore;
  return batch;
}

std::vector<std::size_t> SpeakerSplit::paths_of(std::span<const std::size_t> episodes) const {
  std::vector<std::size_t> paths;
  for (const std::size_t at : episodes) paths.push_back(episodes_.episodes[at].path);
  return paths;
}

at::Tensor SpeakerSplit::sentences(std::span<const std::size_t> episodes) const {
  std::vector<std::vector<std::int64_t>> chosen;
  for (const std::size_t at : episodes) chosen.push_back(ids_[at]);
  return pad_sentences(chosen);
}

std::vector<std::vector<std::string>> tell_split(SpeakerNetwork& network, SpeakerSplit& split,
                                                 const TellSplitOptions& options,
                                                 const Progress& progress) {
  network.set_dropout(std::nullopt);
  const std::size_t total = split.episodes().paths.size();
  std::vector<std::vector<std::string>> told;
  detail::for_each_batch(total, options.batch_size, [&](std::span<const std::size_t> paths) {
    TellOptions own{split.words().begin(),
                    options.choice,
                    options.most_words,
                    options.seed,
                    {paths.begin(), paths.end()}};
    std::optional<EnvironmentalDropoutOptions> environment = options.environment;
    if (environment) environment->stream = paths.front() / options.batch_size;
    for (const auto& ids : tell(network, split.see(paths, environment), own)) {
      std::vector<std::string>& words = told.emplace_back();
      for (const std::int64_t id : ids) words.push_back(split.words().word(id));
    }
    if (progress) progress(told.size(), total);
  });
  return told;
}

models::TellingRecord score_telling(SpeakerNetwork& network, SpeakerSplit& split,
                                    std::size_t batch_size, const Progress& progress) {
  const tasks::EpisodeSet& episodes = split.episodes();
  if (episodes.episodes.empty()) {
    throw ArgumentError(fmt::format("split {}: no instruction to foretell", episodes.split));
  }
  const c10::NoGradGuard no_gradients;
  network.set_dropout(std::nullopt);
  models::TellingRecord record;
  record.split = episodes.split;
  record.instructions = episodes.episodes.size();
  double sum = 0;
  std::size_t words = 0, correct = 0;
  detail::for_each_batch(record.instructions, batch_size, [&](std::span<const std::size_t> batch) {
    const TellingLoss loss =
        telling_loss(network, split.see(split.paths_of(batch)), split.sentences(batch));
    sum += loss.sum;
    words += loss.words;
    correct += loss.correct;
  });
  record.loss = sum / static_cast<double>(words);
  record.perplexity = std::exp(record.loss);
  record.accuracy = static_cast<double>(correct) / static_cast<double>(words);
  const auto told = tell_split(network, split, {.batch_size = batch_size}, progress);
  std::vector<Telling> corpus(told.size());
  for (std::size_t i = 0; i < told.size(); ++i) corpus[i].told = told[i];
  for (const tasks::Episode& episode : episodes.episodes) {
    corpus[episode.path].references.push_back(tasks::tokenize(episode.text));
  }
  std::erase_if(corpus, [](const Telling& telling) { return telling.references.empty(); });
  record.bleu = bleu_4(corpus);
  return record;
}

}  // namespace enfilade::neural::panoramic
