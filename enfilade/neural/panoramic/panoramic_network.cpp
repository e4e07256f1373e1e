#include "enfilade/neural/panoramic/panoramic_network.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/lstm_parts.h"
#include "enfilade/neural/core/transformer_ops.h"

namespace enfilade::neural::panoramic {
namespace {

constexpr double kNone = -std::numeric_limits<double>::infinity();

bool is_embedding(std::string_view name) { return name == "encoder.embedding.weight"; }

// The bound of the uniform distribution that PyTorch's modules draw from: of LSTMs by their hidden
// size, of linear layers by their inputs.
double bound_of(const PanoramicConfig& config, const core::ArraySpec& spec) {
  std::int64_t size = static_cast<std::int64_t>(config.hidden);
  if (spec.name.starts_with("encoder.lstm.") && config.bidirectional) size /= 2;
  if (spec.name.find(".lstm.") == std::string::npos) {
    if (spec.shape.size() == 2) size = spec.shape[1];
    if (spec.name == "decoder.embedding.0.bias") size = static_cast<std::int64_t>(config.angle);
  }
  return 1 / std::sqrt(static_cast<double>(size));
}

// Scores of vectors against a query: (n, k, d) and (n, d) to (n, k).
at::Tensor scores(const at::Tensor& vectors, const at::Tensor& query) {
  return (vectors * query.unsqueeze(1)).sum(2);
}

void check_words(const WordBatch& words, const PanoramicConfig& config) {
  if (!words.ids.defined() || words.ids.dim() != 2 ||
      words.ids.size(0) != static_cast<std::int64_t>(words.lengths.size()) ||
      words.lengths.empty()) {
    throw ArgumentError("words: ids and lengths are not of equally many sentences, from 1");
  }
  std::int64_t before = words.ids.size(1);
  for (const std::int64_t length : words.lengths) {
    if (length < 1 || length > before) {
      throw ArgumentError(fmt::format(
          "words: a sentence of {} after one of {}; lengths fall, and are from 1", length, before));
    }
    before = length;
  }
  const auto least = words.ids.min().item<std::int64_t>();
  const auto most = words.ids.max().item<std::int64_t>();
  if (least < 0 || most >= static_cast<std::int64_t>(config.vocabulary)) {
    throw ArgumentError(fmt::format("words: id {}, not from 0 to {}", least < 0 ? least : most,
                                    config.vocabulary - 1));
  }
}

}  // namespace

PanoramicNetwork::PanoramicNetwork(const PanoramicConfig& config, std::uint64_t seed,
                                   c10::Device device)
    : config_(config), device_(device) {
  validate(config);
  for (const core::ArraySpec& spec : array_specs(config)) {
    weights_.emplace(
        spec.name, core::first_values(spec, is_embedding(spec.name), bound_of(config, spec), seed));
  }
  core::make_trainable(weights_, device);
}

PanoramicNetwork::PanoramicNetwork(const PanoramicConfig& config, const features::TensorFile& file,
                                   c10::Device device)
    : config_(config), device_(device) {
  validate(config);
  weights_ = core::read_weights(file, array_specs(config), [](std::string_view) { return false; });
  core::make_trainable(weights_, device);
}

const at::Tensor& PanoramicNetwork::weight(std::string_view name) const {
  return core::weight_of(weights_, name);
}

void PanoramicNetwork::set_dropout(std::optional<std::uint64_t> seed) {
  dropout_.reset();
  if (seed) dropout_.emplace(*seed, device_);
}

at::Tensor PanoramicNetwork::drop(const at::Tensor& x, double rate) {
  return dropout_ ? (*dropout_)(x, rate) : x;
}

at::Tensor PanoramicNetwork::drop_images(const at::Tensor& features, FeaturesDropped dropped) {
  if (!dropout_ || dropped == FeaturesDropped::kBefore) return features;
  return core::drop_pictures(features, config_.image, config_.feature_dropout, *dropout_);
}

at::Tensor PanoramicNetwork::linear(const at::Tensor& x, const std::string& name) const {
  return core::linear(x, weight(name + ".weight"), weight(name + ".bias"));
}

Encoding PanoramicNetwork::encode(const WordBatch& words) {
  check_words(words, config_);
  const std::int64_t longest = words.ids.size(1);
  const at::Tensor lengths = at::tensor(words.lengths, at::kLong);
  const at::Tensor embedded = drop(
      at::embedding(weight("encoder.embedding.weight"), words.ids.to(device_), 0), config_.dropout);
  const auto [context, hidden, cells] =
      core::read_rows(weights_, "encoder.lstm", config_.bidirectional, embedded, lengths);
  const auto joined = [&](const at::Tensor& state) {
    return config_.bidirectional ? at::cat({state[1], state[0]}, 1) : state[0];
  };
  const at::Tensor ends = lengths.to(device_);
  Encoding encoding;
  encoding.mask = at::arange(longest, ends.options()).unsqueeze(0).ge(ends.unsqueeze(1));
  at::Tensor from = joined(hidden);
  if (config_.subout == Subout::kMax) from = std::get<0>(context.max(1));
  if (config_.subout == Subout::kOwnMax) {
    from = std::get<0>(context.masked_fill(encoding.mask.unsqueeze(2), kNone).max(1));
  }
  encoding.start = at::tanh(linear(from, "encoder.encoder2decoder"));
  encoding.cell = joined(cells);
  encoding.context = drop(context, config_.dropout);
  encoding.words = core::Memory(encoding.context, ends);
  return encoding;
}

StepOutput PanoramicNetwork::step(const Encoding& encoding, const DecoderState& state,
                                  const StepInput& input) {
  StepOutput out;
  const at::Tensor own =
      drop(at::tanh(linear(input.action.to(device_), "decoder.embedding.0")), config_.dropout);
  const at::Tensor views = drop_images(input.views.to(device_), input.dropped);
  const at::Tensor query = core::linear(drop(state.tilde, config_.dropout),
                                        weight("decoder.feat_att_layer.linear_in.weight"));
  const core::Memory panorama(
      views, at::full({views.size(0)}, views.size(1), views.options().dtype(at::kLong)));
  std::tie(out.attended_view, out.view_attention) = panorama.attend(query);
  // The hidden state of the LSTM is the one after attention: the published code never uses the
  // other.
  std::tie(out.hidden, out.next.cell) =
      core::lstm_step(at::cat({own, out.attended_view}, 1), state.tilde, state.cell,
                      {weight("decoder.lstm.weight_ih"), weight("decoder.lstm.weight_hh"),
                       weight("decoder.lstm.bias_ih"), weight("decoder.lstm.bias_hh")});
  const at::Tensor dropped = drop(out.hidden, config_.dropout);
  const at::Tensor asked =
      core::linear(dropped, weight("decoder.attention_layer.linear_in.weight"));
  const auto [read, shares] = encoding.words.attend(asked);
  out.word_attention = shares;
  out.next.tilde = at::tanh(core::linear(at::cat({read, dropped}, 1),
                                         weight("decoder.attention_layer.linear_out.weight")));
  const at::Tensor choice = core::linear(drop(out.next.tilde, config_.dropout),
                                         weight("decoder.candidate_att_layer.linear_in.weight"));
  out.logits = scores(drop_images(input.candidates.to(device_), input.dropped), choice)
                   .masked_fill(input.closed.to(device_), kNone);
  return out;
}

at::Tensor PanoramicNetwork::value(const at::Tensor& hidden) {
  const at::Tensor inner = drop(at::relu(linear(hidden, "critic.state2value.0")), config_.dropout);
  return linear(inner, "critic.state2value.3").squeeze(1);
}

}  // namespace enfilade::neural::panoramic
