#include "enfilade/neural/speaker/speaker_split.h"

#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/batches.h"
#include "enfilade/neural/speaker/bleu.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::neural::speaker {
namespace {

void check_known(const tasks::EpisodeSet& episodes) {
  for (const tasks::ReferencePath& path : episodes.paths) {
    if (!goal_hidden(path)) continue;
    throw ArgumentError(fmt::format(
        "split {}: its goals are hidden, so its paths cannot be described", episodes.split));
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
  ids_ = words.encode(episodes, config.network.max_words, true);
  if (features != nullptr) features_.emplace(*features, episodes);
  images_ = panoramic::pictures_of(features_ ? &*features_ : nullptr);
}

PathBatch SpeakerSplit::see(std::span<const std::size_t> paths,
                            const std::optional<EnvironmentalDropoutOptions>& environment) {
  std::vector<PathToDescribe> seen;
  for (const std::size_t at : paths) {
    const tasks::ReferencePath& path = episodes_.paths[at];
    seen.push_back({path.scan, path.heading, path.viewpoints});
  }
  const ImageSource images = environment ? drop_environment(images_, *environment) : images_;
  PathBatch batch = see_paths(seen, sizes_, images, panoramas_, *episodes_.graphs);
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

std::vector<std::vector<std::string>> describe_split(SpeakerNetwork& network, SpeakerSplit& split,
                                                     const DescribeSplitOptions& options,
                                                     const Progress& progress) {
  network.set_dropout(std::nullopt);
  Ranks alone;
  Ranks& ranks = options.ranks != nullptr ? *options.ranks : alone;
  const std::size_t total = split.episodes().paths.size();
  std::size_t described = 0;
  const auto batches = core::share_batches(
      ranks, total, options.batch_size, [&](std::span<const std::size_t> paths) {
        DescribeOptions own{split.words().begin(),
                            options.choice,
                            options.most_words,
                            options.seed,
                            {paths.begin(), paths.end()}};
        std::optional<EnvironmentalDropoutOptions> environment = options.environment;
        if (environment) environment->stream = paths.front() / options.batch_size;
        std::vector<std::vector<std::string>> texts;
        for (const auto& ids : describe(network, split.see(paths, environment), own)) {
          std::vector<std::string>& words = texts.emplace_back();
          for (const std::int64_t id : ids) words.push_back(split.words().word(id));
        }
        described += paths.size();
        if (progress) {
          progress(std::min(total, described * static_cast<std::size_t>(ranks.size())), total);
        }
        return core::packed(texts);
      });
  std::vector<std::vector<std::string>> texts;
  for (const std::string& batch : batches) {
    for (auto& text : core::unpacked<std::vector<std::vector<std::string>>>(batch)) {
      texts.push_back(std::move(text));
    }
  }
  return texts;
}

models::SpeakerRecord score_speaker(SpeakerNetwork& network, SpeakerSplit& split,
                                    std::size_t batch_size, Ranks* among,
                                    const Progress& progress) {
  Ranks alone;
  Ranks& ranks = among != nullptr ? *among : alone;
  const tasks::EpisodeSet& episodes = split.episodes();
  if (episodes.episodes.empty()) {
    throw ArgumentError(fmt::format("split {}: no instruction to predict", episodes.split));
  }
  const c10::NoGradGuard no_gradients;
  network.set_dropout(std::nullopt);
  models::SpeakerRecord record;
  record.split = episodes.split;
  record.instructions = episodes.episodes.size();
  double sum = 0;
  std::size_t words = 0, correct = 0;
  struct Counted {
    double sum = 0;
    std::size_t words = 0, correct = 0;
  };
  const auto counted = core::share_batches(
      ranks, record.instructions, batch_size, [&](std::span<const std::size_t> batch) {
        const InstructionLoss loss =
            instruction_loss(network, split.see(split.paths_of(batch)), split.sentences(batch));
        return core::packed(Counted{loss.sum, loss.words, loss.correct});
      });
  for (const std::string& batch : counted) {
    const auto one = core::unpacked<Counted>(batch);
    sum += one.sum;
    words += one.words;
    correct += one.correct;
  }
  record.loss = sum / static_cast<double>(words);
  record.perplexity = std::exp(record.loss);
  record.accuracy = static_cast<double>(correct) / static_cast<double>(words);
  const auto texts =
      describe_split(network, split, {.batch_size = batch_size, .ranks = &ranks}, progress);
  std::vector<Generated> corpus(texts.size());
  for (std::size_t i = 0; i < texts.size(); ++i) corpus[i].words = texts[i];
  for (const tasks::Episode& episode : episodes.episodes) {
    corpus[episode.path].references.push_back(tasks::tokenize(episode.text));
  }
  std::erase_if(corpus, [](const Generated& one) { return one.references.empty(); });
  record.bleu = bleu_4(corpus);
  return record;
}

}  // namespace enfilade::neural::speaker
