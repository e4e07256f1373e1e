#include "enfilade/neural/speaker/speaker_network.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <cctype>
#include <limits>
#include <numeric>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"
#include "enfilade/tasks/tokenizer.h"

namespace enfilade::neural::speaker {
namespace {

constexpr std::int64_t kViewsOfStep = 36;
constexpr std::string_view kUnused = "decoder.baseline_projection.";

std::int64_t whole(std::size_t size) { return static_cast<std::int64_t>(size); }

std::int64_t direction_size(const SpeakerConfig& config) {
  return whole(config.bidirectional ? config.hidden / 2 : config.hidden);
}

// PyTorch's modules draw uniformly within +-1 / sqrt(of this): of LSTMs their hidden size,
// of linear layers their inputs. 0: a table of words.
std::int64_t fan_of(const SpeakerConfig& config, const core::ArraySpec& spec) {
  if (spec.name == "decoder.embedding.weight") return 0;
  if (spec.name.starts_with("decoder.lstm.") || spec.name == "decoder.projection.bias") {
    return whole(config.hidden);
  }
  if (spec.name.find("lstm.") != std::string::npos) return direction_size(config);
  return spec.shape[1];
}

bool fits(const at::Tensor& tensor, std::initializer_list<std::int64_t> shape) {
  return tensor.defined() && tensor.sizes() == at::IntArrayRef(shape);
}

void check_paths(const PathBatch& paths, const SpeakerConfig& config) {
  const std::int64_t n = std::ssize(paths.lengths), feature = whole(config.feature());
  const std::int64_t longest =
      paths.actions.defined() && paths.actions.dim() == 3 ? paths.actions.size(1) : 0;
  if (n == 0 || longest == 0 || !fits(paths.actions, {n, longest, feature}) ||
      !fits(paths.views, {n, longest, kViewsOfStep, feature})) {
    throw ArgumentError(fmt::format(
        "paths: actions, views and lengths are not of equally many paths, from 1, with {} numbers "
        "a view",
        feature));
  }
  for (const std::int64_t length : paths.lengths) {
    if (length >= 1 && length <= longest) continue;
    throw ArgumentError(fmt::format("paths: a length of {}, not from 1 to {}", length, longest));
  }
}

void check_ids(const at::Tensor& words, std::int64_t rows, const SpeakerConfig& config) {
  if (!words.defined() || words.dim() != 2 || words.size(0) != rows || words.size(1) == 0) {
    throw ArgumentError(fmt::format("words: not a row of at least one for each of {} paths", rows));
  }
  const auto least = words.min().item<std::int64_t>();
  const auto most = words.max().item<std::int64_t>();
  if (least >= 0 && most < whole(config.vocabulary)) return;
  throw ArgumentError(fmt::format("words: id {}, not from 0 to {}", least < 0 ? least : most,
                                  config.vocabulary - 1));
}

// Rows by falling length, as packing wants them.
at::Tensor falling_order(const std::vector<std::int64_t>& lengths) {
  std::vector<std::int64_t> order(lengths.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::stable_sort(order, std::greater<>{},
                           [&](std::int64_t i) { return lengths[static_cast<std::size_t>(i)]; });
  return at::tensor(order, at::kLong);
}

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
  std::vector<std::int64_t> choose(const at::Tensor& logits) {
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

std::vector<core::ArraySpec> array_specs(const SpeakerConfig& config) {
  const std::int64_t hidden = whole(config.hidden), feature = whole(config.feature());
  const std::int64_t words = whole(config.word_embedding), all = whole(config.vocabulary);
  const std::int64_t direction = direction_size(config);
  std::vector<core::ArraySpec> specs;
  for (const char* suffix : {"_l0", "_l0_reverse"}) {
    if (suffix != std::string_view("_l0") && !config.bidirectional) continue;
    core::add_lstm(specs, "encoder.lstm.", suffix, feature, direction);
    core::add_lstm(specs, "encoder.post_lstm.", suffix, hidden, direction);
  }
  core::add_attention(specs, "encoder.attention_layer", hidden, feature);
  specs.push_back({"decoder.embedding.weight", {all, words}});
  core::add_lstm(specs, "decoder.lstm.", "_l0", words, hidden);
  core::add_attention(specs, "decoder.attention_layer", hidden, hidden);
  core::add_layer(specs, "decoder.projection", {all, hidden});
  return specs;
}

SpeakerNetwork::SpeakerNetwork(const SpeakerConfig& config, std::uint64_t seed, c10::Device device)
    : LstmNetwork(
          array_specs(core::checked(config)),
          [&](const core::ArraySpec& spec) { return fan_of(config, spec); }, seed, device),
      config_(config) {}

SpeakerNetwork::SpeakerNetwork(const SpeakerConfig& config, const features::TensorFile& file,
                               c10::Device device)
    : LstmNetwork(array_specs(core::checked(config)), file, device,
                  [](std::string_view name) { return name.starts_with(kUnused); }),
      config_(config) {}

at::Tensor SpeakerNetwork::drop_images(const at::Tensor& features, FeaturesDropped dropped) {
  if (dropped == FeaturesDropped::kBefore) return features;
  return drop_pictures(features, config_.image, config_.feature_dropout);
}

// An LSTM of the encoder over the steps of each path, (n, longest, input) to (n, longest, hidden).
at::Tensor SpeakerNetwork::read_steps(const at::Tensor& x, const PathBatch& paths,
                                      const std::string& name) {
  const at::Tensor order = falling_order(paths.lengths);
  const at::Tensor lengths = at::tensor(paths.lengths, at::kLong).index_select(0, order);
  const at::Tensor there = order.to(device());
  return core::read_rows(weights(), name, config_.bidirectional, x.index_select(0, there), lengths)
      .outputs.index_select(0, at::argsort(there));
}

PathEncoding SpeakerNetwork::encode(const PathBatch& paths) {
  check_paths(paths, config_);
  const at::Tensor actions = drop_images(paths.actions.to(device()), paths.dropped);
  const at::Tensor steps = drop(read_steps(actions, paths, "encoder.lstm"), config_.dropout);
  const at::Tensor views = drop_images(paths.views.to(device()), paths.dropped);
  const at::Tensor query = at::linear(steps, weight("encoder.attention_layer.linear_in.weight"));
  const at::Tensor shares =
      at::softmax(at::matmul(views, query.unsqueeze(3)).squeeze(3), 2);  // (n, longest, 36)
  const at::Tensor attended = at::matmul(shares.unsqueeze(2), views).squeeze(2);
  const at::Tensor seen = at::tanh(at::linear(at::cat({attended, steps}, 2),
                                              weight("encoder.attention_layer.linear_out.weight")));
  PathEncoding encoding;
  encoding.context =
      drop(read_steps(drop(seen, config_.dropout), paths, "encoder.post_lstm"), config_.dropout);
  encoding.mask = at::arange(paths.actions.size(1), at::kLong)
                      .unsqueeze(0)
                      .ge(at::tensor(paths.lengths, at::kLong).unsqueeze(1))
                      .to(device());
  return encoding;
}

SpeakerState SpeakerNetwork::begin(std::int64_t n) const {
  const at::TensorOptions options = at::TensorOptions(at::kFloat).device(device());
  return {at::zeros({n, whole(config_.hidden)}, options),
          at::zeros({n, whole(config_.hidden)}, options)};
}

at::Tensor SpeakerNetwork::decode(const PathEncoding& encoding, const at::Tensor& words,
                                  SpeakerState& state) {
  check_ids(words, encoding.context.size(0), config_);
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  const at::Tensor embedded = drop(
      at::embedding(weight("decoder.embedding.weight"), words.to(device()), 0), config_.dropout);
  const std::vector<at::Tensor> parameters{
      weight("decoder.lstm.weight_ih_l0"), weight("decoder.lstm.weight_hh_l0"),
      weight("decoder.lstm.bias_ih_l0"), weight("decoder.lstm.bias_hh_l0")};
  const auto [outputs, hidden, cell] =
      at::lstm(embedded, {state.hidden.unsqueeze(0), state.cell.unsqueeze(0)}, parameters, true, 1,
               0.0, true, false, true);
  state = {hidden.squeeze(0), cell.squeeze(0)};
  const at::Tensor said = drop(outputs, config_.dropout);
  const at::Tensor query = at::linear(said, weight("decoder.attention_layer.linear_in.weight"));
  const at::Tensor scores = at::bmm(query, encoding.context.transpose(1, 2))
                                .masked_fill(encoding.mask.unsqueeze(1), kNone);
  const at::Tensor attended = at::bmm(at::softmax(scores, 2), encoding.context);
  const at::Tensor tilde = at::tanh(at::linear(
      at::cat({attended, said}, 2), weight("decoder.attention_layer.linear_out.weight")));
  return at::linear(drop(tilde, config_.dropout), weight("decoder.projection.weight"),
                    weight("decoder.projection.bias"));
}

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
