#include "enfilade/neural/duet/duet_network.h"

#include <fmt/format.h>
#include <algorithm>
#include <string>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::neural::duet {
namespace {

constexpr std::int64_t kPublishedHead = 64;  // columns of a head

class Specs {
 public:
  explicit Specs(const DuetConfig& config) : c_(config) {}

  std::vector<core::ArraySpec> list() {
    text();
    panorama();
    branch("vln_bert.local_encoder", "vp_pos_embeddings", 2 * kPosition);
    add("vln_bert.global_encoder.gmap_step_embeddings.weight", {c_.steps, c_.hidden});
    branch("vln_bert.global_encoder", "gmap_pos_embeddings", kPosition);
    if (c_.map_distances) linear("vln_bert.global_encoder.sprel_linear", 1, 1);
    head("vln_bert.global_sap_head", c_.hidden);
    head("vln_bert.local_sap_head", c_.hidden);
    if (c_.fusion == Fusion::kDynamic) head("vln_bert.sap_fuse_linear", 2 * c_.hidden);
    if (c_.object != 0) head("vln_bert.og_head", c_.hidden);
    return std::move(specs_);
  }

 private:
  void add(std::string name, std::vector<std::int64_t> shape) {
    specs_.push_back({std::move(name), std::move(shape)});
  }
  void linear(const std::string& name, std::int64_t out, std::int64_t in) {
    core::add_layer(specs_, name, {out, in});
  }
  void norm(const std::string& name) { core::add_layer(specs_, name, {c_.hidden}); }
  void attention(const std::string& inner, const std::string& output) {
    for (const char* part : {".query", ".key", ".value"})
      linear(inner + part, c_.hidden, c_.hidden);
    linear(output + ".dense", c_.hidden, c_.hidden);
    norm(output + ".LayerNorm");
  }
  void feed_forward(const std::string& inner, const std::string& output) {
    linear(inner + ".dense", c_.feed_forward, c_.hidden);
    linear(output + ".dense", c_.hidden, c_.feed_forward);
    norm(output + ".LayerNorm");
  }

  void text() {
    const std::string table = "vln_bert.embeddings";
    add(table + ".word_embeddings.weight", {c_.vocabulary, c_.hidden});
    add(table + ".position_embeddings.weight", {c_.positions, c_.hidden});
    add(table + ".token_type_embeddings.weight", {c_.token_types, c_.hidden});
    norm(table + ".LayerNorm");
    for (std::int64_t i = 0; i < c_.text_layers; ++i) {
      const std::string layer = fmt::format("vln_bert.lang_encoder.layer.{}", i);
      attention(layer + ".attention.self", layer + ".attention.output");
      feed_forward(layer + ".intermediate", layer + ".output");
    }
  }

  void panorama() {
    const std::string table = "vln_bert.img_embeddings";
    linear(table + ".img_linear", c_.hidden, c_.image);
    norm(table + ".img_layer_norm");
    linear(table + ".loc_linear", c_.hidden, kLocation);
    norm(table + ".loc_layer_norm");
    if (c_.own_object_map()) {
      linear(table + ".obj_linear", c_.hidden, c_.object);
      norm(table + ".obj_layer_norm");
    }
    add(table + ".nav_type_embedding.weight", {3, c_.hidden});
    norm(table + ".layer_norm");
    for (std::int64_t i = 0; i < c_.panorama_layers; ++i) {
      const std::string layer = fmt::format("{}.pano_encoder.layers.{}", table, i);
      add(layer + ".self_attn.in_proj_weight", {3 * c_.hidden, c_.hidden});
      add(layer + ".self_attn.in_proj_bias", {3 * c_.hidden});
      linear(layer + ".self_attn.out_proj", c_.hidden, c_.hidden);
      linear(layer + ".linear1", c_.panorama_feed_forward, c_.hidden);
      linear(layer + ".linear2", c_.hidden, c_.panorama_feed_forward);
      norm(layer + ".norm1");
      norm(layer + ".norm2");
    }
    if (c_.panorama_layers > 0) norm(table + ".pano_encoder.norm");
  }

  void branch(const std::string& name, const std::string& position, std::int64_t numbers) {
    linear(fmt::format("{}.{}.0", name, position), c_.hidden, numbers);
    norm(fmt::format("{}.{}.1", name, position));
    for (std::int64_t i = 0; i < c_.cross_layers; ++i) {
      const std::string layer = fmt::format("{}.encoder.x_layers.{}", name, i);
      attention(layer + ".visual_attention.att", layer + ".visual_attention.output");
      attention(layer + ".visn_self_att.self", layer + ".visn_self_att.output");
      feed_forward(layer + ".visn_inter", layer + ".visn_output");
    }
  }

  void head(const std::string& name, std::int64_t in) {
    linear(name + ".net.0", c_.hidden, in);
    norm(name + ".net.2");
    linear(name + ".net.3", 1, c_.hidden);
  }

  const DuetConfig& c_;
  std::vector<core::ArraySpec> specs_;
};

// How many layers there are: the first number that the pattern has no array for.
std::int64_t count(const core::Shapes& shapes, const std::string& before,
                   const std::string& after) {
  std::int64_t n = 0;
  while (shapes.has(fmt::format("{}{}{}", before, n, after))) ++n;
  return n;
}

}  // namespace

DuetConfig infer_config(const features::TensorFile& file, std::int64_t heads) {
  const std::string image = "vln_bert.img_embeddings", map = "vln_bert.global_encoder";
  core::Shapes shapes(file);
  DuetConfig c;
  c.vocabulary = shapes.side("vln_bert.embeddings.word_embeddings.weight", 0);
  c.hidden = shapes.side("vln_bert.embeddings.word_embeddings.weight", 1);
  c.positions = shapes.side("vln_bert.embeddings.position_embeddings.weight", 0);
  c.token_types = shapes.side("vln_bert.embeddings.token_type_embeddings.weight", 0);
  c.image = shapes.side(image + ".img_linear.weight", 1);
  c.steps = shapes.side(map + ".gmap_step_embeddings.weight", 0);
  c.text_layers = count(shapes, "vln_bert.lang_encoder.layer.", ".output.dense.weight");
  c.cross_layers = count(shapes, map + ".encoder.x_layers.", ".visn_output.dense.weight");
  c.panorama_layers = count(shapes, image + ".pano_encoder.layers.", ".linear1.weight");
  c.feed_forward = shapes.side(map + ".encoder.x_layers.0.visn_inter.dense.weight", 0);
  c.panorama_feed_forward = c.panorama_layers > 0
                                ? shapes.side(image + ".pano_encoder.layers.0.linear1.weight", 0)
                                : c.feed_forward;
  c.map_distances = shapes.has(map + ".sprel_linear.weight");
  c.fusion =
      shapes.has("vln_bert.sap_fuse_linear.net.0.weight") ? Fusion::kDynamic : Fusion::kAverage;
  if (shapes.has("vln_bert.og_head.net.0.weight")) {
    c.object = shapes.has(image + ".obj_linear.weight")
                   ? shapes.side(image + ".obj_linear.weight", 1)
                   : c.image;
  }
  shapes.check();
  c.heads = heads > 0 ? heads : std::max<std::int64_t>(1, c.hidden / kPublishedHead);
  c.max_words = std::min(c.max_words, c.positions);
  validate(c);
  return c;
}

std::vector<core::ArraySpec> arrays_of(const DuetConfig& config) { return Specs(config).list(); }

}  // namespace enfilade::neural::duet
