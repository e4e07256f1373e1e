#include "enfilade/neural/speaker/speaker_decoding.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <limits>
#include <optional>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::neural::speaker {
namespace {

using tasks::Vocabulary;

// What look() reads of the listener's sizes.
panoramic::PanoramicConfig sizes_of_views(const SpeakerConfig& config) {
  panoramic::PanoramicConfig sizes;
  sizes.image = config.image;
  sizes.angle = config.angle;
  return sizes;
}

void check_described(std::span<const PathToDescribe> paths) {
  if (paths.empty()) throw ArgumentError("paths: none to describe");
  for (std::size_t i = 0; i < paths.size(); ++i) {
    if (paths[i].viewpoints.empty()) {
      throw ArgumentError(fmt::format("paths[{}]: no viewpoint", i));
    }
  }
}

// The choice that leads to the next viewpoint of a path, or to its end.
std::size_t choice_along(const PathToDescribe& path, std::size_t step,
                         const panoramic::PanoramicEpisode& walk, std::size_t at) {
  if (step + 1 == path.viewpoints.size()) return walk.stop();
  const auto& candidates = walk.candidates();
  const auto chosen =
      std::ranges::find(candidates, path.viewpoints[step + 1], &sim::Candidate::viewpoint);
  if (chosen == candidates.end()) {
    throw ArgumentError(
        fmt::format("paths[{}]: viewpoint {} is no neighbour of the one before", at, step + 1));
  }
  return static_cast<std::size_t>(chosen - candidates.begin());
}

// Chooses the next words of all sentences.
class WordChooser {
 public:
  WordChooser(const DescribeOptions& options, std::size_t rows) : options_(options) {
    for (std::size_t i = 0; i < rows; ++i) {
      rngs_.emplace_back(options.seed, options.streams.empty() ? i : options.streams[i]);
    }
  }

  // \param logits (n, vocabulary)
  std::vector<std::int64_t> choose(at::Tensor logits) {
    constexpr double kNever = -std::numeric_limits<double>::infinity();
    for (const std::int64_t id :
         {std::int64_t{Vocabulary::kPad}, std::int64_t{Vocabulary::kUnknown}, options_.begin}) {
      logits.select(1, id).fill_(kNever);
    }
    const bool draw = options_.choice == WordChoice::kDrawn;
    const at::Tensor values = (draw ? at::softmax(logits, 1) : logits).contiguous();
    const auto width = static_cast<std::size_t>(values.size(1));
    std::vector<std::int64_t> chosen;
    for (std::size_t i = 0; i < rngs_.size(); ++i) {
      const std::span<const float> row(values.data_ptr<float>() + i * width, width);
      chosen.push_back(draw ? drawn(row, rngs_[i]) : std::ranges::max_element(row) - row.begin());
    }
    return chosen;
  }

 private:
  static std::int64_t drawn(std::span<const float> shares, Rng& rng) {
    double left = rng.uniform();
    std::int64_t last = Vocabulary::kEnd;  // if rounding leaves something
    for (std::size_t k = 0; k < shares.size(); ++k) {
      if (shares[k] <= 0) continue;
      last = static_cast<std::int64_t>(k);
      left -= static_cast<double>(shares[k]);
      if (left < 0) break;
    }
    return last;
  }

  const DescribeOptions& options_;
  std::vector<Rng> rngs_;
};

void check_options(const SpeakerConfig& config, const PathBatch& paths,
                   const DescribeOptions& options) {
  if (options.begin <= Vocabulary::kEnd ||
      options.begin >= static_cast<std::int64_t>(config.vocabulary)) {
    throw ArgumentError(fmt::format("begin: id {}, not from {} to {}", options.begin,
                                    Vocabulary::kEnd + 1, config.vocabulary - 1));
  }
  if (!options.streams.empty() && options.streams.size() != paths.lengths.size()) {
    throw ArgumentError(
        fmt::format("streams: {} for {} paths", options.streams.size(), paths.lengths.size()));
  }
}

}  // namespace

PathBatch see_paths(std::span<const PathToDescribe> paths, const SpeakerConfig& config,
                    const ImageSource& images, agents::PanoramaCache& panoramas,
                    const graph::GraphSet& graphs) {
  check_described(paths);
  PathBatch batch;
  for (const PathToDescribe& path : paths) batch.lengths.push_back(std::ssize(path.viewpoints));
  const auto n = std::ssize(paths), longest = std::ranges::max(batch.lengths);
  const auto feature = static_cast<std::int64_t>(config.feature());
  const panoramic::PanoramicConfig sizes = sizes_of_views(config);
  batch.actions = at::zeros({n, longest, feature}, at::kFloat);
  batch.views = at::zeros({n, longest, 36, feature}, at::kFloat);
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const PathToDescribe& path = paths[i];
    const auto row = static_cast<std::int64_t>(i);
    panoramic::PanoramicEpisode walk(
        panoramas, graphs, {{path.scan, path.viewpoints.front()}, path.heading, std::nullopt});
    for (std::size_t step = 0; step < path.viewpoints.size(); ++step) {
      const auto t = static_cast<std::int64_t>(step);
      const std::size_t choice = choice_along(path, step, walk, i);
      const panoramic::StepInput seen = look(std::span(&walk, 1), sizes, images);
      batch.views[row][t].copy_(seen.views[0]);
      batch.actions[row][t].copy_(seen.candidates[0][static_cast<std::int64_t>(choice)]);
      walk.choose(choice);
    }
  }
  return batch;
}

at::Tensor pad_sentences(std::span<const std::vector<std::int64_t>> sentences) {
  if (sentences.empty()) throw ArgumentError("sentences: none");
  std::size_t longest = 0;
  for (const auto& sentence : sentences) {
    if (sentence.size() < 2) throw ArgumentError("sentences: one has less than two words");
    longest = std::max(longest, sentence.size());
  }
  at::Tensor ids =
      at::zeros({std::ssize(sentences), static_cast<std::int64_t>(longest)}, at::kLong);
  for (std::size_t i = 0; i < sentences.size(); ++i) {
    std::ranges::copy(sentences[i], ids.data_ptr<std::int64_t>() + i * longest);
  }
  return ids;
}

InstructionLoss instruction_loss(SpeakerNetwork& network, const PathBatch& paths,
                                 const at::Tensor& sentences) {
  if (!sentences.defined() || sentences.dim() != 2 || sentences.size(1) < 2) {
    throw ArgumentError("sentences: no word is to be predicted");
  }
  const std::int64_t length = sentences.size(1) - 1;
  SpeakerState state = network.begin(sentences.size(0));
  const at::Tensor logits =
      network.decode(network.encode(paths), sentences.narrow(1, 0, length), state);
  const at::Tensor truth = sentences.narrow(1, 1, length).reshape({-1}).to(logits.device());
  const at::Tensor logs = at::log_softmax(logits, 2).reshape({truth.size(0), -1});
  const at::Tensor meant = truth.ne(std::int64_t{Vocabulary::kPad});
  const auto words = meant.sum().item<std::int64_t>();
  if (words == 0) throw ArgumentError("sentences: no word is to be predicted");
  const at::Tensor sum = -logs.gather(1, truth.unsqueeze(1)).squeeze(1).masked_select(meant).sum();
  InstructionLoss loss;
  loss.mean = sum / static_cast<double>(words);
  loss.sum = sum.item<double>();
  loss.words = static_cast<std::size_t>(words);
  loss.correct = static_cast<std::size_t>(
      logs.detach().argmax(1).eq(truth).logical_and(meant).sum().item<std::int64_t>());
  return loss;
}

std::vector<std::vector<std::int64_t>> describe(SpeakerNetwork& network, const PathBatch& paths,
                                                const DescribeOptions& options) {
  check_options(network.config(), paths, options);
  const c10::NoGradGuard no_gradients;
  const PathEncoding encoding = network.encode(paths);
  const std::size_t n = paths.lengths.size();
  SpeakerState state = network.begin(std::ssize(paths.lengths));
  WordChooser chooser(options, n);
  std::vector<std::vector<std::int64_t>> sentences(n);
  std::vector<std::int64_t> words(n, options.begin);
  std::vector<bool> ended(n, false);
  for (std::size_t t = 0; t < options.most_words; ++t) {
    const at::Tensor last = at::tensor(words, at::kLong).unsqueeze(1);
    words = chooser.choose(
        network.decode(encoding, last, state).squeeze(1).to(at::kCPU, at::kFloat, false, true));
    for (std::size_t i = 0; i < n; ++i) {
      ended[i] = ended[i] || words[i] == std::int64_t{Vocabulary::kEnd};
      if (ended[i]) words[i] = Vocabulary::kPad;
      if (!ended[i]) sentences[i].push_back(words[i]);
    }
    if (std::ranges::all_of(ended, [](bool done) { return done; })) break;
  }
  return sentences;
}

std::string join_words(std::span<const std::string> words) {
  const auto is_mark = [](const std::string& word) {
    const auto first = static_cast<unsigned char>(word.empty() ? '_' : word.front());
    return first < 128 && first != '_' && std::isalnum(first) == 0;
  };
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const bool after_mark = i > 0 && is_mark(words[i - 1]);
    const bool joined = after_mark ? is_mark(words[i]) : words[i] == "." || words[i] == ",";
    if (i > 0 && !joined) text += ' ';
    text += words[i];
  }
  return text;
}

}  // namespace enfilade::neural::speaker
