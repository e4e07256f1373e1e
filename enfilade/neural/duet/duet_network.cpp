#include "enfilade/neural/duet/duet_network.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <cmath>
#include <limits>
#include <string_view>

#include "enfilade/core/check.h"
#include "enfilade/neural/core/transformer_ops.h"

namespace enfilade::neural::duet {
namespace {

constexpr double kDeviation = 0.02;  // BERT's initializer_range
constexpr double kInfinity = std::numeric_limits<double>::infinity();

at::Tensor uniform(const std::vector<std::int64_t>& shape, Rng& rng) {
  const double bound = std::sqrt(6.0 / static_cast<double>(shape[0] + shape[1]));
  at::Tensor values = at::empty(shape, at::kFloat);
  auto* numbers = values.data_ptr<float>();
  for (std::int64_t i = 0; i < values.numel(); ++i) {
    numbers[i] = static_cast<float>((2 * rng.uniform() - 1) * bound);
  }
  return values;
}

bool is_norm(std::string_view name) {
  for (const char* part : {"LayerNorm.", "layer_norm.", ".norm1.", ".norm2.", ".norm.", ".net.2.",
                           "pos_embeddings.1."}) {
    if (name.find(part) != std::string_view::npos) return true;
  }
  return false;
}

at::Tensor initial(const core::ArraySpec& spec, Rng& rng) {
  const std::string_view name = spec.name;
  if (name.ends_with("bias")) return at::zeros(spec.shape, at::kFloat);
  if (is_norm(name)) return at::ones(spec.shape, at::kFloat);
  if (name.ends_with("in_proj_weight")) return uniform(spec.shape, rng);
  at::Tensor values = core::normal(spec.shape, kDeviation, rng);
  if (name.ends_with("word_embeddings.weight")) values[0].zero_();  // padding
  return values;
}

// What the published code saves beside the network's weights.
bool ignored(std::string_view name) {
  return name.ends_with("position_ids") || !name.starts_with("vln_bert.");
}

constexpr double kTorchEpsilon = 1e-5;  // default of torch.nn.LayerNorm

}  // namespace

at::Tensor mask_of(const at::Tensor& lengths, std::int64_t longest) {
  return at::arange(longest, lengths.options()).unsqueeze(0).lt(lengths.unsqueeze(1));
}

core::Weights random_weights(std::span<const core::ArraySpec> specs, Rng rng) {
  core::Weights weights;
  for (const core::ArraySpec& spec : specs) weights.emplace(spec.name, initial(spec, rng));
  return weights;
}

PanoramaInput PanoramaInput::on(c10::Device device) const {
  PanoramaInput there = *this;
  for (at::Tensor* part : {&there.views, &there.view_counts, &there.objects, &there.object_counts,
                           &there.locations, &there.types}) {
    if (part->defined()) *part = part->to(device);
  }
  return there;
}

NavigationInput NavigationInput::on(c10::Device device) const {
  NavigationInput there = *this;
  for (at::Tensor* part :
       {&there.nodes, &there.steps, &there.node_positions, &there.node_mask, &there.visited,
        &there.distances, &there.tokens, &there.token_positions, &there.token_mask, &there.choices,
        &there.objects, &there.node_of_token}) {
    if (part->defined()) *part = part->to(device);
  }
  return there;
}

DuetNetwork::DuetNetwork(const DuetConfig& config, std::uint64_t seed, c10::Device device)
    : config_(config), device_(device) {
  validate(config);
  weights_ = random_weights(arrays_of(config), Rng(seed));
  core::make_trainable(weights_, device);
}

DuetNetwork::DuetNetwork(const DuetConfig& config, const features::TensorFile& file,
                         c10::Device device)
    : config_(config), device_(device) {
  validate(config);
  weights_ = core::read_weights(file, arrays_of(config), ignored);
  core::make_trainable(weights_, device);
}

Tokens DuetNetwork::encode_text(const at::Tensor& given_ids, const at::Tensor& lengths,
                                RateDropout* dropout) const {
  const at::Tensor ids = given_ids.to(device_);
  const Layers layers(weights_, config_.heads, dropout);
  const std::string table = "vln_bert.embeddings";
  const at::Tensor mask = mask_of(lengths.to(device_), ids.size(1));
  at::Tensor x = at::embedding(layers.weight(table + ".word_embeddings.weight"), ids, 0) +
                 layers.weight(table + ".position_embeddings.weight").narrow(0, 0, ids.size(1)) +
                 layers.weight(table + ".token_type_embeddings.weight")[0];
  x = layers.drop(layers.norm(x, table + ".LayerNorm"));
  const at::Tensor bias = bias_of(mask, kSoftMask);
  for (std::int64_t i = 0; i < config_.text_layers; ++i) {
    const std::string layer = fmt::format("vln_bert.lang_encoder.layer.{}", i);
    x = layers.attention(x, x, bias, layer + ".attention.self", layer + ".attention.output");
    x = layers.feed_forward(x, layer + ".intermediate", layer + ".output");
  }
  return {x, mask};
}

Tokens DuetNetwork::encode_panorama(const PanoramaInput& given, RateDropout* dropout) const {
  const PanoramaInput input = given.on(device_);
  const Layers layers(weights_, config_.heads, dropout);
  const std::string table = "vln_bert.img_embeddings";
  const std::int64_t longest = input.locations.size(1);
  at::Tensor x =
      layers.norm(layers.linear(input.views, table + ".img_linear"), table + ".img_layer_norm");
  at::Tensor counts = input.view_counts;
  const at::Tensor place = at::arange(longest, counts.options()).unsqueeze(0);
  at::Tensor from = place.expand({x.size(0), longest});
  if (input.objects.defined() && input.objects.size(1) > 0) {
    const std::string kind = config_.own_object_map() ? ".obj" : ".img";
    const at::Tensor objects = layers.norm(layers.linear(input.objects, table + kind + "_linear"),
                                           table + kind + "_layer_norm");
    const at::Tensor views = input.view_counts.unsqueeze(1);
    from = at::where(place.lt(views), place, place - views + x.size(1));
    x = at::cat({x, objects}, 1);
    counts = counts + input.object_counts;
  }
  const at::Tensor mask = mask_of(counts, longest);
  from = at::where(mask, from, at::zeros_like(from));
  x = x.gather(1, from.unsqueeze(2).expand({x.size(0), longest, config_.hidden}));
  x = x +
      layers.norm(layers.linear(input.locations, table + ".loc_linear"),
                  table + ".loc_layer_norm") +
      at::embedding(layers.weight(table + ".nav_type_embedding.weight"), input.types) +
      layers.weight("vln_bert.embeddings.token_type_embeddings.weight")[1];
  x = layers.drop(layers.norm(x, table + ".layer_norm"));
  if (config_.panorama_layers == 0) return {x, mask};
  const at::Tensor bias = bias_of(mask, -kInfinity);
  for (std::int64_t i = 0; i < config_.panorama_layers; ++i) {
    x = layers.pre_norm_layer(x, bias, fmt::format("{}.pano_encoder.layers.{}", table, i));
  }
  return {layers.norm(x, table + ".pano_encoder.norm"), mask};
}

PreparedText PreparedText::rows(const at::Tensor& which) const {
  PreparedText some{mask.index_select(0, which), {}, {}};
  const auto select = [&](const std::vector<Attended>& all, std::vector<Attended>& into) {
    for (const Attended& one : all) {
      into.push_back({one.keys.index_select(0, which), one.values.index_select(0, which)});
    }
  };
  select(map, some.map);
  select(viewpoint, some.viewpoint);
  return some;
}

PreparedText DuetNetwork::prepare(const Tokens& text) const {
  const Layers layers(weights_, config_.heads, nullptr);
  const at::Tensor words = text.values.to(device_);
  PreparedText prepared{text.mask.to(device_), {}, {}};
  const auto inner = [](const char* branch, std::int64_t layer) {
    return fmt::format("vln_bert.{}.encoder.x_layers.{}.visual_attention.att", branch, layer);
  };
  for (std::int64_t i = 0; i < config_.cross_layers; ++i) {
    prepared.map.push_back(layers.attended(words, inner("global_encoder", i)));
    prepared.viewpoint.push_back(layers.attended(words, inner("local_encoder", i)));
  }
  return prepared;
}

at::Tensor DuetNetwork::branch(const Layers& layers, at::Tensor x, const PreparedText& text,
                               const std::vector<Attended>& words, const at::Tensor& mask,
                               const at::Tensor& bias, const char* name) const {
  const at::Tensor padding = bias_of(text.mask, kSoftMask);
  at::Tensor own = bias_of(mask, kSoftMask);
  if (bias.defined()) own = own + bias;
  for (std::int64_t i = 0; i < config_.cross_layers; ++i) {
    const std::string layer = fmt::format("vln_bert.{}.encoder.x_layers.{}", name, i);
    x = layers.attention(x, words[static_cast<std::size_t>(i)], padding,
                         layer + ".visual_attention.att", layer + ".visual_attention.output");
    x = layers.attention(x, x, own, layer + ".visn_self_att.self", layer + ".visn_self_att.output");
    x = layers.feed_forward(x, layer + ".visn_inter", layer + ".visn_output");
  }
  return x;
}

at::Tensor DuetNetwork::embed_nodes(const NavigationInput& input) const {
  const Layers layers(weights_, config_.heads, nullptr);
  const std::string map = "vln_bert.global_encoder";
  return input.nodes +
         at::embedding(layers.weight(map + ".gmap_step_embeddings.weight"), input.steps) +
         layers.norm(layers.linear(input.node_positions, map + ".gmap_pos_embeddings.0"),
                     map + ".gmap_pos_embeddings.1");
}

at::Tensor DuetNetwork::embed_tokens(const NavigationInput& input) const {
  const Layers layers(weights_, config_.heads, nullptr);
  const std::string here = "vln_bert.local_encoder.vp_pos_embeddings";
  return input.tokens + layers.norm(layers.linear(input.token_positions, here + ".0"), here + ".1");
}

NavigationOutput DuetNetwork::navigate(const PreparedText& text, const NavigationInput& given,
                                       RateDropout* dropout) const {
  const NavigationInput input = given.on(device_);
  const Layers layers(weights_, config_.heads, dropout);
  const std::string map = "vln_bert.global_encoder";
  NavigationOutput out;
  at::Tensor bias;
  if (config_.map_distances) {
    bias = (input.distances * layers.weight(map + ".sprel_linear.weight").squeeze() +
            layers.weight(map + ".sprel_linear.bias").squeeze())
               .unsqueeze(1);
  }
  out.nodes =
      branch(layers, embed_nodes(input), text, text.map, input.node_mask, bias, "global_encoder");
  out.tokens = branch(layers, embed_tokens(input), text, text.viewpoint, input.token_mask, {},
                      "local_encoder");
  fuse(layers, input, out);
  if (config_.object != 0 && input.objects.defined()) {
    out.object_logits = layers.head(out.tokens, "vln_bert.og_head")
                            .masked_fill(input.objects.logical_not(), -kInfinity);
  }
  return out;
}

void DuetNetwork::fuse(const Layers& layers, const NavigationInput& input,
                       NavigationOutput& out) const {
  const std::int64_t n = input.nodes.size(0), g = input.nodes.size(1);
  out.global_scores = layers.head(out.nodes, "vln_bert.global_sap_head");
  out.local_scores = layers.head(out.tokens, "vln_bert.local_sap_head");
  out.fuse_weight = at::full({n, 1}, 0.5, out.global_scores.options());
  if (config_.fusion == Fusion::kDynamic) {
    const at::Tensor both = at::cat({out.nodes.select(1, 0), out.tokens.select(1, 0)}, 1);
    out.fuse_weight = at::sigmoid(layers.head(both, "vln_bert.sap_fuse_linear")).unsqueeze(1);
  }
  const at::Tensor global = out.global_scores * out.fuse_weight;
  const at::Tensor local = out.local_scores * (1 - out.fuse_weight);
  const at::Tensor open = input.visited.logical_not().logical_and(input.node_mask);
  out.global_logits = global.masked_fill(open.logical_not(), -kInfinity);
  out.local_logits = local.masked_fill(input.choices.logical_not(), -kInfinity);
  // Candidates on the map give their logit to their node; those visited to all the open nodes that
  // are no candidates.
  const at::Tensor row = input.node_of_token;
  const at::Tensor candidate = row.gt(0);
  const at::Tensor known = at::where(candidate, row, at::zeros_like(row));
  const at::Tensor back = input.visited.gather(1, known).logical_and(candidate);
  const at::Tensor own = known.unsqueeze(1)
                             .eq(at::arange(g, row.options()).view({1, g, 1}))
                             .logical_and(candidate.logical_and(back.logical_not()).unsqueeze(1));
  const at::Tensor others = own.any(2, true).logical_not().logical_and(back.unsqueeze(1));
  at::Tensor share = own.logical_or(others).to(at::kFloat);
  share = share * open.unsqueeze(2);
  at::Tensor stop = at::zeros_like(share.select(1, 0));
  stop.select(1, 0).fill_(1);
  share.select(1, 0).copy_(stop);
  out.fused_logits = out.global_logits + at::bmm(share, local.unsqueeze(2)).squeeze(2);
}

at::Tensor bias_of(const at::Tensor& mask, double padding) {
  return at::zeros(mask.sizes(), mask.options().dtype(at::kFloat))
      .masked_fill(mask.logical_not(), padding)
      .unsqueeze(1)
      .unsqueeze(1);
}

const at::Tensor& Layers::weight(const std::string& name) const {
  const auto found = weights_.find(name);
  EN_CHECK(found != weights_.end());
  return found->second;
}

at::Tensor Layers::drop(const at::Tensor& values) const {
  return dropout_ == nullptr ? values : (*dropout_)(values);
}

at::Tensor Layers::linear(const at::Tensor& x, const std::string& name) const {
  return core::linear(x, weight(name + ".weight"), weight(name + ".bias"));
}

at::Tensor Layers::norm(const at::Tensor& x, const std::string& name, double eps) const {
  return core::sum_norm(x, {}, {}, weight(name + ".weight"), weight(name + ".bias"), eps);
}

at::Tensor Layers::mask(at::IntArrayRef sizes) const {
  return dropout_ == nullptr ? at::Tensor() : dropout_->mask(sizes);
}

at::Tensor Layers::sum_norm(const at::Tensor& y, const at::Tensor& x,
                            const std::string& name) const {
  const at::Tensor &scale = weight(name + ".weight"), &bias = weight(name + ".bias");
  if (!y.device().is_cpu()) return core::sum_norm(drop(y), x, {}, scale, bias, kBertEpsilon);
  return core::sum_norm(y, x, mask(y.sizes()), scale, bias, kBertEpsilon);
}

at::Tensor Layers::attend(const at::Tensor& query, const at::Tensor& key, const at::Tensor& value,
                          const at::Tensor& bias) const {
  if (!query.device().is_cpu()) {
    const double rate = dropout_ == nullptr ? 0 : dropout_->rate();
    return core::attend_on_card(query, key, value, bias, rate, heads_);
  }
  const at::Tensor kept = mask({query.size(0), heads_, query.size(1), key.size(1)});
  return core::attend(query, key, value, bias, kept, heads_);
}

at::Tensor Layers::attention(const at::Tensor& x, const at::Tensor& to, const at::Tensor& bias,
                             const std::string& inner, const std::string& output) const {
  return attention(x, attended(to, inner), bias, inner, output);
}

Attended Layers::attended(const at::Tensor& to, const std::string& inner) const {
  return {linear(to, inner + ".key"), linear(to, inner + ".value")};
}

at::Tensor Layers::attention(const at::Tensor& x, const Attended& to, const at::Tensor& bias,
                             const std::string& inner, const std::string& output) const {
  const at::Tensor seen = attend(linear(x, inner + ".query"), to.keys, to.values, bias);
  return sum_norm(linear(seen, output + ".dense"), x, output + ".LayerNorm");
}

at::Tensor Layers::feed_forward(const at::Tensor& x, const std::string& inner,
                                const std::string& output) const {
  const at::Tensor wide = core::gelu(linear(x, inner + ".dense"));
  return sum_norm(linear(wide, output + ".dense"), x, output + ".LayerNorm");
}

at::Tensor Layers::pre_norm_layer(const at::Tensor& x, const at::Tensor& bias,
                                  const std::string& name) const {
  const at::Tensor before = norm(x, name + ".norm1", kTorchEpsilon);
  const auto parts = core::linear(before, weight(name + ".self_attn.in_proj_weight"),
                                  weight(name + ".self_attn.in_proj_bias"))
                         .chunk(3, -1);
  const at::Tensor seen = attend(parts[0], parts[1], parts[2], bias);
  const at::Tensor y = x + drop(linear(seen, name + ".self_attn.out_proj"));
  const at::Tensor wide =
      core::gelu(linear(norm(y, name + ".norm2", kTorchEpsilon), name + ".linear1"));
  return y + drop(linear(drop(wide), name + ".linear2"));
}

at::Tensor Layers::head(const at::Tensor& x, const std::string& name) const {
  const at::Tensor inner = norm(at::relu(linear(x, name + ".net.0")), name + ".net.2");
  return linear(inner, name + ".net.3").squeeze(-1);
}

}  // namespace enfilade::neural::duet
