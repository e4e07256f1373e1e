#include "enfilade/neural/panoramic/panoramic_config.h"

#include <string>
#include <string_view>

#include "enfilade/neural/core/lstm_parts.h"

namespace enfilade::neural::panoramic {
namespace {

void add_linear(std::vector<core::ArraySpec>& specs, const std::string& name, std::int64_t output,
                std::int64_t input) {
  specs.push_back({name + ".weight", {output, input}});
  specs.push_back({name + ".bias", {output}});
}

// Attention of `hidden` to vectors of `context` numbers; it has no bias.
void add_attention(std::vector<core::ArraySpec>& specs, const std::string& name,
                   std::int64_t hidden, std::int64_t context) {
  specs.push_back({name + ".linear_in.weight", {context, hidden}});
  specs.push_back({name + ".linear_out.weight", {hidden, hidden + context}});
}

std::int64_t as_int(std::size_t size) { return static_cast<std::int64_t>(size); }

}  // namespace

std::vector<core::ArraySpec> array_specs(const PanoramicConfig& config) {
  const std::int64_t hidden = as_int(config.hidden), words = as_int(config.word_embedding);
  const std::int64_t action = as_int(config.action_embedding), feature = as_int(config.feature());
  const std::int64_t direction = config.bidirectional ? hidden / 2 : hidden;
  std::vector<core::ArraySpec> specs{
      {"encoder.embedding.weight", {as_int(config.vocabulary), words}}};
  core::add_lstm(specs, "encoder.lstm.", "_l0", words, direction);
  if (config.bidirectional) core::add_lstm(specs, "encoder.lstm.", "_l0_reverse", words, direction);
  add_linear(specs, "encoder.encoder2decoder", hidden, hidden);
  add_linear(specs, "decoder.embedding.0", action, as_int(config.angle));
  core::add_lstm(specs, "decoder.lstm.", "", action + feature, hidden);
  add_attention(specs, "decoder.feat_att_layer", hidden, feature);
  add_attention(specs, "decoder.attention_layer", hidden, hidden);
  add_attention(specs, "decoder.candidate_att_layer", hidden, feature);
  add_linear(specs, "critic.state2value.0", hidden, hidden);
  add_linear(specs, "critic.state2value.3", 1, hidden);
  return specs;
}

PanoramicConfig config_of(const features::TensorFile& file, const PanoramicConfig& defaults) {
  PanoramicConfig config = defaults;
  constexpr std::string_view kViews = "decoder.feat_att_layer.linear_in.weight";
  core::MatrixSides sides(file, "EnvDrop's listener");
  config.vocabulary = sides.side("encoder.embedding.weight", 0);
  config.word_embedding = sides.side("encoder.embedding.weight", 1);
  config.action_embedding = sides.side("decoder.embedding.0.weight", 0);
  config.angle = sides.side("decoder.embedding.0.weight", 1);
  config.hidden = sides.side("decoder.lstm.weight_hh", 1);
  config.image = sides.image(kViews, sides.side(kViews, 0), config.angle);
  config.bidirectional = file.find("encoder.lstm.weight_ih_l0_reverse") != nullptr;
  sides.validate_all(config);
  return config;
}

}  // namespace enfilade::neural::panoramic
