#include "enfilade/neural/speaker/speaker_network.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/neural/core/batches.h"
#include "enfilade/neural/core/learner.h"
#include "enfilade/neural/speaker.h"
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

constexpr std::size_t kOrders = 4;

using Words = std::span<const std::string>;
using NgramCounts = std::map<std::vector<std::string>, std::size_t>;

NgramCounts count_ngrams(Words words, std::size_t order) {
  NgramCounts counts;
  for (std::size_t i = 0; i + order <= words.size(); ++i) {
    const Words ngram = words.subspan(i, order);
    ++counts[{ngram.begin(), ngram.end()}];
  }
  return counts;
}

std::size_t count_matches(const Generated& one, std::size_t order) {
  NgramCounts most;
  for (const auto& reference : one.references) {
    for (const auto& [ngram, count] : count_ngrams(reference, order)) {
      most[ngram] = std::max(most[ngram], count);
    }
  }
  std::size_t matches = 0;
  for (const auto& [ngram, count] : count_ngrams(one.words, order)) {
    const auto found = most.find(ngram);
    if (found != most.end()) matches += std::min(count, found->second);
  }
  return matches;
}

void check_rate(double rate) {
  if (rate >= 0 && rate < 1) return;
  throw ArgumentError(fmt::format("environmental dropout: {}, not in [0, 1)", rate));
}

class SpeakerLearner : public core::SplitLearner<SpeakerNetwork, SpeakerSplit> {
 public:
  explicit SpeakerLearner(const core::LearnerParts& parts)
      : SplitLearner(parts,
                     SpeakerNetwork(speaker_sizes(parts.config), parts.config.seed, parts.device),
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

double bleu_4(std::span<const Generated> corpus) {
  std::array<std::size_t, kOrders> matches{}, possible{};
  std::size_t written = 0, meant = 0;
  for (const Generated& one : corpus) {
    written += one.words.size();
    std::size_t shortest = one.references.front().size();
    for (const auto& reference : one.references) {
      shortest = std::min(shortest, reference.size());
    }
    meant += shortest;
    for (std::size_t n = 0; n < kOrders; ++n) {
      matches[n] += count_matches(one, n + 1);
      if (one.words.size() > n) possible[n] += one.words.size() - n;
    }
  }
  double logs = 0;
  for (std::size_t n = 0; n < kOrders; ++n) {
    if (matches[n] == 0) return 0;
    logs += std::log(static_cast<double>(matches[n]) / static_cast<double>(possible[n])) / kOrders;
  }
  const double ratio = static_cast<double>(written) / static_cast<double>(meant);
  return std::exp(logs + (ratio > 1 ? 0 : 1 - 1 / ratio));
}

std::vector<float> column_factors(const EnvironmentalDropoutOptions& options, std::size_t columns) {
  check_rate(options.rate);
  Rng rng(options.seed, options.stream, 0);
  const auto kept = static_cast<float>(1 / (1 - options.rate));
  std::vector<float> factors(columns);
  for (float& factor : factors) factor = rng.uniform() < options.rate ? 0.0F : kept;
  return factors;
}

ImageSource drop_environment(ImageSource images, const EnvironmentalDropoutOptions& options) {
  check_rate(options.rate);
  // Shared by copies of the function, which all have the same factors.
  const auto known = std::make_shared<std::vector<float>>();
  return [images = std::move(images), options, known](graph::Location at, std::uint32_t view,
                                                      std::span<float> out) {
    images(at, view, out);
    std::vector<float>& factors = *known;
    if (factors.size() != out.size()) factors = column_factors(options, out.size());
    for (std::size_t c = 0; c < out.size(); ++c) out[c] *= factors[c];
  };
}

}  // namespace enfilade::neural::speaker

namespace enfilade::neural::core {

std::unique_ptr<Learner> make_speaker_learner(const LearnerParts& parts) {
  return std::make_unique<speaker::SpeakerLearner>(parts);
}

}  // namespace enfilade::neural::core

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
    : impl_(std::make_shared<Impl>(folder, models::require_model(folder))) {}

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
                                                           options.environment_seed, 0};
  }
  std::vector<std::string> texts;
  for (const auto& words : speaker::describe_split(impl_->network, split, own, progress)) {
    texts.push_back(speaker::join_words(words));
  }
  return texts;
}

}  // namespace enfilade::neural
