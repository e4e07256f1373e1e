#include "enfilade/neural/panoramic/panoramic_network.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <limits>
#include <string>
#include <tuple>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/transformer_ops.h"

namespace enfilade::neural::panoramic {
namespace {

std::int64_t as_int(std::size_t size) { return static_cast<std::int64_t>(size); }

constexpr double kNone = -std::numeric_limits<double>::infinity();

// PyTorch's modules draw uniformly within +-1 / sqrt(of this): of LSTMs their hidden size,
// of linear layers their inputs. 0: a table of words.
std::int64_t fan_of(const PanoramicConfig& config, const core::ArraySpec& spec) {
  if (spec.name == "encoder.embedding.weight") return 0;
  const std::int64_t hidden = as_int(config.hidden);
  if (spec.name.starts_with("encoder.lstm.") && config.bidirectional) return hidden / 2;
  if (spec.name.find(".lstm.") != std::string::npos) return hidden;
  if (spec.shape.size() == 2) return spec.shape[1];
  return spec.name == "decoder.embedding.0.bias" ? as_int(config.angle) : hidden;
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

std::vector<core::ArraySpec> array_specs(const PanoramicConfig& config) {
  const std::int64_t hidden = as_int(config.hidden), words = as_int(config.word_embedding);
  const std::int64_t action = as_int(config.action_embedding), feature = as_int(config.feature());
  const std::int64_t direction = config.bidirectional ? hidden / 2 : hidden;
  std::vector<core::ArraySpec> specs{
      {"encoder.embedding.weight", {as_int(config.vocabulary), words}}};
  core::add_lstm(specs, "encoder.lstm.", "_l0", words, direction);
  if (config.bidirectional) core::add_lstm(specs, "encoder.lstm.", "_l0_reverse", words, direction);
  core::add_layer(specs, "encoder.encoder2decoder", {hidden, hidden});
  core::add_layer(specs, "decoder.embedding.0", {action, as_int(config.angle)});
  core::add_lstm(specs, "decoder.lstm.", "", action + feature, hidden);
  core::add_attention(specs, "decoder.feat_att_layer", hidden, feature);
  core::add_attention(specs, "decoder.attention_layer", hidden, hidden);
  core::add_attention(specs, "decoder.candidate_att_layer", hidden, feature);
  core::add_layer(specs, "critic.state2value.0", {hidden, hidden});
  core::add_layer(specs, "critic.state2value.3", {1, hidden});
  return specs;
}

PanoramicConfig config_of(const features::TensorFile& file, const PanoramicConfig& defaults) {
  PanoramicConfig config = defaults;
  const std::string views = "decoder.feat_att_layer.linear_in.weight";
  core::Shapes shapes(file);
  const auto side = [&shapes](const std::string& name, std::size_t which) {
    return static_cast<std::size_t>(shapes.side(name, which));
  };
  config.vocabulary = side("encoder.embedding.weight", 0);
  config.word_embedding = side("encoder.embedding.weight", 1);
  config.action_embedding = side("decoder.embedding.0.weight", 0);
  config.angle = side("decoder.embedding.0.weight", 1);
  config.hidden = side("decoder.lstm.weight_hh", 1);
  const std::size_t feature = side(views, 0);
  shapes.check();
  if (feature < config.angle) {
    refuse(file.path().string(), views, "wrong-shape",
           fmt::format("{} numbers a view, fewer than the {} of its angle", feature, config.angle));
  }
  config.image = feature - config.angle;
  config.bidirectional = shapes.has("encoder.lstm.weight_ih_l0_reverse");
  try {
    validate(config);
  } catch (const ArgumentError& wrong) {
    refuse(file.path().string(), "", "wrong-shape", wrong.what());
  }
  return config;
}

PanoramicNetwork::PanoramicNetwork(const PanoramicConfig& config, std::uint64_t seed,
                                   c10::Device device)
    : LstmNetwork(
          array_specs(core::checked(config)),
          [&](const core::ArraySpec& spec) { return fan_of(config, spec); }, seed, device),
      config_(config) {}

PanoramicNetwork::PanoramicNetwork(const PanoramicConfig& config, const features::TensorFile& file,
                                   c10::Device device)
    : LstmNetwork(array_specs(core::checked(config)), file, device), config_(config) {}

at::Tensor PanoramicNetwork::drop_images(const at::Tensor& features, FeaturesDropped dropped) {
  if (dropped == FeaturesDropped::kBefore) return features;
  return drop_pictures(features, config_.image, config_.feature_dropout);
}

at::Tensor PanoramicNetwork::linear(const at::Tensor& x, const std::string& name) const {
  return core::linear(x, weight(name + ".weight"), weight(name + ".bias"));
}

Encoding PanoramicNetwork::encode(const WordBatch& words) {
  check_words(words, config_);
  const std::int64_t longest = words.ids.size(1);
  const at::Tensor lengths = at::tensor(words.lengths, at::kLong);
  const at::Tensor embedded =
      drop(at::embedding(weight("encoder.embedding.weight"), words.ids.to(device()), 0),
           config_.dropout);
  const auto [context, hidden, cells] =
      core::read_rows(weights(), "encoder.lstm", config_.bidirectional, embedded, lengths);
  const auto joined = [&](const at::Tensor& state) {
    return config_.bidirectional ? at::cat({state[1], state[0]}, 1) : state[0];
  };
  const at::Tensor ends = lengths.to(device());
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
  encoding.words = core::AttentionMemory(encoding.context, ends);
  return encoding;
}

StepOutput PanoramicNetwork::step(const Encoding& encoding, const DecoderState& state,
                                  const StepInput& input) {
  StepOutput out;
  const at::Tensor own =
      drop(at::tanh(linear(input.action.to(device()), "decoder.embedding.0")), config_.dropout);
  const at::Tensor views = drop_images(input.views.to(device()), input.dropped);
  const at::Tensor query = core::linear(drop(state.tilde, config_.dropout),
                                        weight("decoder.feat_att_layer.linear_in.weight"));
  const core::AttentionMemory panorama(
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
  out.logits = scores(drop_images(input.candidates.to(device()), input.dropped), choice)
                   .masked_fill(input.closed.to(device()), kNone);
  return out;
}

at::Tensor PanoramicNetwork::value(const at::Tensor& hidden) {
  const at::Tensor inner = drop(at::relu(linear(hidden, "critic.state2value.0")), config_.dropout);
  return linear(inner, "critic.state2value.3").squeeze(1);
}

}  // namespace enfilade::neural::panoramic
