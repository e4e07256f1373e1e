#include "enfilade/neural/speaker/speaker_network.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/lstm_parts.h"

namespace enfilade::neural::speaker {
namespace {

constexpr std::int64_t kViewsOfStep = 36;
constexpr std::string_view kUnused = "decoder.baseline_projection.";

std::int64_t whole(std::size_t size) { return static_cast<std::int64_t>(size); }

std::int64_t direction_size(const SpeakerConfig& config) {
  return whole(config.bidirectional ? config.hidden / 2 : config.hidden);
}

// The numbers that PyTorch's modules draw are below 1 / sqrt(of this): of LSTMs their hidden size,
// of linear layers their inputs.
std::int64_t fan_of(const SpeakerConfig& config, const core::ArraySpec& spec) {
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
  specs.push_back({"encoder.attention_layer.linear_in.weight", {feature, hidden}});
  specs.push_back({"encoder.attention_layer.linear_out.weight", {hidden, hidden + feature}});
  specs.push_back({"decoder.embedding.weight", {all, words}});
  core::add_lstm(specs, "decoder.lstm.", "_l0", words, hidden);
  specs.push_back({"decoder.attention_layer.linear_in.weight", {hidden, hidden}});
  specs.push_back({"decoder.attention_layer.linear_out.weight", {hidden, 2 * hidden}});
  specs.push_back({"decoder.projection.weight", {all, hidden}});
  specs.push_back({"decoder.projection.bias", {all}});
  return specs;
}

SpeakerConfig speaker_config_of(const features::TensorFile& file, const SpeakerConfig& defaults) {
  SpeakerConfig config = defaults;
  constexpr std::string_view kViews = "encoder.lstm.weight_ih_l0";
  core::MatrixSides sides(file, "EnvDrop's speaker");
  config.vocabulary = sides.side("decoder.embedding.weight", 0);
  config.word_embedding = sides.side("decoder.embedding.weight", 1);
  config.hidden = sides.side("decoder.projection.weight", 1);
  config.image = sides.image(kViews, sides.side(kViews, 1), config.angle);
  config.bidirectional = file.find("encoder.lstm.weight_ih_l0_reverse") != nullptr;
  sides.validate_all(config);
  return config;
}

SpeakerNetwork::SpeakerNetwork(const SpeakerConfig& config, std::uint64_t seed, c10::Device device)
    : config_(config), device_(device) {
  validate(config);
  for (const core::ArraySpec& spec : array_specs(config)) {
    const double bound = 1 / std::sqrt(static_cast<double>(fan_of(config, spec)));
    weights_.emplace(
        spec.name, core::first_values(spec, spec.name == "decoder.embedding.weight", bound, seed));
  }
  core::make_trainable(weights_, device);
}

SpeakerNetwork::SpeakerNetwork(const SpeakerConfig& config, const features::TensorFile& file,
                               c10::Device device)
    : config_(config), device_(device) {
  validate(config);
  weights_ = core::read_weights(file, array_specs(config),
                                [](std::string_view name) { return name.starts_with(kUnused); });
  core::make_trainable(weights_, device);
}

const at::Tensor& SpeakerNetwork::weight(std::string_view name) const {
  return core::weight_of(weights_, name);
}

void SpeakerNetwork::set_dropout(std::optional<std::uint64_t> seed) {
  dropout_.reset();
  if (seed) dropout_.emplace(*seed, device_);
}

at::Tensor SpeakerNetwork::drop(const at::Tensor& x, double rate) {
  return dropout_ ? (*dropout_)(x, rate) : x;
}

at::Tensor SpeakerNetwork::drop_images(const at::Tensor& features, FeaturesDropped dropped) {
  if (!dropout_ || dropped == FeaturesDropped::kBefore) return features;
  return core::drop_pictures(features, config_.image, config_.feature_dropout, *dropout_);
}

// An LSTM of the encoder over the steps of each path, (n, longest, input) to (n, longest, hidden).
at::Tensor SpeakerNetwork::read_steps(const at::Tensor& x, const PathBatch& paths,
                                      const std::string& name) {
  const at::Tensor order = falling_order(paths.lengths);
  const at::Tensor lengths = at::tensor(paths.lengths, at::kLong).index_select(0, order);
  const at::Tensor there = order.to(device_);
  return core::read_rows(weights_, name, config_.bidirectional, x.index_select(0, there), lengths)
      .outputs.index_select(0, at::argsort(there));
}

PathEncoding SpeakerNetwork::encode(const PathBatch& paths) {
  check_paths(paths, config_);
  const at::Tensor actions = drop_images(paths.actions.to(device_), paths.dropped);
  const at::Tensor steps = drop(read_steps(actions, paths, "encoder.lstm"), config_.dropout);
  const at::Tensor views = drop_images(paths.views.to(device_), paths.dropped);
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
                      .to(device_);
  return encoding;
}

SpeakerState SpeakerNetwork::begin(std::int64_t n) const {
  const at::TensorOptions options = at::TensorOptions(at::kFloat).device(device_);
  return {at::zeros({n, whole(config_.hidden)}, options),
          at::zeros({n, whole(config_.hidden)}, options)};
}

at::Tensor SpeakerNetwork::decode(const PathEncoding& encoding, const at::Tensor& words,
                                  SpeakerState& state) {
  check_ids(words, encoding.context.size(0), config_);
  constexpr double kNone = -std::numeric_limits<double>::infinity();
  const at::Tensor embedded = drop(
      at::embedding(weight("decoder.embedding.weight"), words.to(device_), 0), config_.dropout);
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

}  // namespace enfilade::neural::speaker
