#include "enfilade/neural/duet/pretraining_network.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/neural/core/transformer_ops.h"

namespace enfilade::neural::duet {
namespace {

constexpr const char* kBranches[] = {"local_encoder", "global_encoder"};

// Published code saves its pretraining's language layers below "bert.", not "vln_bert.".
std::string language_layer(std::string_view branch, std::int64_t i) {
  return fmt::format("bert.{}.encoder.x_layers.{}", branch, i);
}

class HeadSpecs {
 public:
  explicit HeadSpecs(const DuetConfig& config) : c_(config) {}

  std::vector<core::ArraySpec> list() {
    for (const char* branch : kBranches) {
      for (std::int64_t i = 0; i < c_.cross_layers; ++i) layer(language_layer(branch, i));
    }
    const std::string words = "mlm_head.predictions";
    linear(words + ".transform.dense", c_.hidden, c_.hidden);
    norm(words + ".transform.LayerNorm");
    add(words + ".bias", {c_.vocabulary});
    if (c_.image > 0) {
      linear("image_classifier.net.0", c_.hidden, c_.hidden);
      norm("image_classifier.net.2");
      linear("image_classifier.net.3", c_.image, c_.hidden);
    }
    return std::move(specs_);
  }

 private:
  void add(std::string name, std::vector<std::int64_t> shape) {
    specs_.push_back({std::move(name), std::move(shape)});
  }
  void linear(const std::string& name, std::int64_t out, std::int64_t in) {
    add(name + ".weight", {out, in});
    add(name + ".bias", {out});
  }
  void norm(const std::string& name) {
    add(name + ".weight", {c_.hidden});
    add(name + ".bias", {c_.hidden});
  }
  void layer(const std::string& name) {
    for (const char* part : {".self.query", ".self.key", ".self.value", ".output.dense"}) {
      linear(name + ".lang_self_att" + part, c_.hidden, c_.hidden);
    }
    norm(name + ".lang_self_att.output.LayerNorm");
    linear(name + ".lang_inter.dense", c_.feed_forward, c_.hidden);
    linear(name + ".lang_output.dense", c_.hidden, c_.feed_forward);
    norm(name + ".lang_output.LayerNorm");
  }

  const DuetConfig& c_;
  std::vector<core::ArraySpec> specs_;
};

bool no_head(std::string_view name) {
  return !name.starts_with("bert.") && !name.starts_with("mlm_head.") &&
         !name.starts_with("image_classifier.");
}

core::Weights heads_of(const DuetConfig& config, const features::TensorFile& file,
                       std::uint64_t seed) {
  const std::vector<core::ArraySpec> specs = pretraining_arrays_of(config);
  const bool any = std::ranges::any_of(
      specs, [&](const core::ArraySpec& spec) { return file.find(spec.name) != nullptr; });
  if (!any) return random_weights(specs, Rng(seed, 1));
  return core::read_weights(file, specs, no_head);
}

core::Weights together(const DuetNetwork& network, core::Weights heads) {
  core::make_trainable(heads, network.device());
  heads.insert(network.weights().begin(), network.weights().end());
  return heads;
}

at::Tensor rows_of(const at::Tensor& values, const at::Tensor& which) {
  return values.reshape({-1, values.size(2)}).index_select(0, which.to(values.device()));
}

}  // namespace

std::vector<core::ArraySpec> pretraining_arrays_of(const DuetConfig& config) {
  return HeadSpecs(config).list();
}

PretrainingNetwork::PretrainingNetwork(const DuetConfig& config, std::uint64_t seed,
                                       c10::Device device)
    : agent_(config, seed, device),
      weights_(together(agent_, random_weights(pretraining_arrays_of(config), Rng(seed, 1)))) {}

PretrainingNetwork::PretrainingNetwork(const DuetConfig& config, const features::TensorFile& file,
                                       std::uint64_t seed, c10::Device device)
    : agent_(config, file, device), weights_(together(agent_, heads_of(config, file, seed))) {}

std::vector<core::ArraySpec> PretrainingNetwork::arrays() const {
  std::vector<core::ArraySpec> all = arrays_of(config());
  for (core::ArraySpec& spec : pretraining_arrays_of(config())) all.push_back(std::move(spec));
  return all;
}

at::Tensor PretrainingNetwork::text_side(const Layers& layers, const Tokens& text,
                                         const at::Tensor& vision, const at::Tensor& mask,
                                         const char* branch) const {
  const at::Tensor words = bias_of(text.mask, kSoftMask), seen = bias_of(mask, kSoftMask);
  at::Tensor x = text.values;
  for (std::int64_t i = 0; i < config().cross_layers; ++i) {
    // The same weights that take vision to the text.
    const std::string cross =
        fmt::format("vln_bert.{}.encoder.x_layers.{}.visual_attention", branch, i);
    const std::string own = language_layer(branch, i);
    x = layers.attention(x, vision, seen, cross + ".att", cross + ".output");
    x = layers.attention(x, x, words, own + ".lang_self_att.self", own + ".lang_self_att.output");
    x = layers.feed_forward(x, own + ".lang_inter", own + ".lang_output");
  }
  return x;
}

at::Tensor PretrainingNetwork::guess_words(const Tokens& text, const NavigationInput& input,
                                           const at::Tensor& masked, Dropout* dropout) const {
  const Layers layers(weights_, config().heads, dropout);
  const at::Tensor both =
      text_side(layers, text, agent_.embed_nodes(input), input.node_mask, "global_encoder") +
      text_side(layers, text, agent_.embed_tokens(input), input.token_mask, "local_encoder");
  const std::string head = "mlm_head.predictions";
  const at::Tensor inner =
      core::gelu(layers.linear(rows_of(both, masked), head + ".transform.dense"));
  return at::linear(layers.norm(inner, head + ".transform.LayerNorm"),
                    layers.weight("vln_bert.embeddings.word_embeddings.weight"),
                    layers.weight(head + ".bias"));
}

at::Tensor PretrainingNetwork::guess_views(const NavigationOutput& output,
                                           const at::Tensor& masked) const {
  EN_CHECK(config().image > 0);
  const Layers layers(weights_, config().heads, nullptr);
  const std::string head = "image_classifier.net";
  const at::Tensor inner = core::gelu(layers.linear(rows_of(output.tokens, masked), head + ".0"));
  return layers.linear(layers.norm(inner, head + ".2"), head + ".3");
}

}  // namespace enfilade::neural::duet
