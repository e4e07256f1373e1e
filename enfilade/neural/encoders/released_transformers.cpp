#include <ATen/ATen.h>
#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/encoders/encoder_input.h"
#include "enfilade/neural/encoders/transformer_encoder.h"

namespace enfilade::neural::encoders {
namespace {

using features::TensorFile;

constexpr std::int64_t kOutputs = 512;
// Of the pictures that CLIP was trained on, as published with it.
constexpr render::Normalisation kClip{{0.48145466F, 0.4578275F, 0.40821073F},
                                      {0.26862954F, 0.26130258F, 0.27577711F}};
constexpr const char* kOutput = "visual.proj";  // (width, outputs): what is on the left is a row

TransformerSizes sizes_of(const std::string& name) {
  TransformerSizes sizes;
  sizes.patch = name == "clip-vit-b-32" ? 32 : 16;
  sizes.epsilon = 1e-5;
  sizes.activation = Activation::kQuickGelu;
  return sizes;
}

// OpenAI's; OpenCLIP has kept them.
TransformerNames clip_names() {
  return {.class_token = "visual.class_embedding",
          .positions = "visual.positional_embedding",
          .patches = "visual.conv1",
          .before = "visual.ln_pre",
          .after = "visual.ln_post",
          .block = "visual.transformer.resblocks.{}.",
          .norm1 = "ln_1",
          .qkv_weight = "attn.in_proj_weight",
          .qkv_bias = "attn.in_proj_bias",
          .proj = "attn.out_proj",
          .norm2 = "ln_2",
          .fc1 = "mlp.c_fc",
          .fc2 = "mlp.c_proj",
          .patch_bias = false,
          .leading_ones = false};
}

std::vector<core::ArraySpec> clip_arrays(const TransformerSizes& sizes) {
  std::vector<core::ArraySpec> arrays = transformer_arrays(clip_names(), sizes);
  arrays.push_back({kOutput, {sizes.width, kOutputs}});
  return arrays;
}

// The encoder of texts, and numbers that no picture meets.
bool is_of_text(std::string_view name) { return !name.starts_with("visual."); }
bool is_of_text_in_transformers(std::string_view name) {
  return !(name.starts_with("vision_model.") || name.starts_with("visual_projection.")) ||
         name.ends_with(".position_ids");
}

// --- Hugging Face's names ---

constexpr std::array<std::pair<std::string_view, std::string_view>, 11> kTransformers{{
    {"visual.class_embedding", "vision_model.embeddings.class_embedding"},
    {"visual.positional_embedding", "vision_model.embeddings.position_embedding.weight"},
    {"visual.conv1.", "vision_model.embeddings.patch_embedding."},
    {"visual.ln_pre.", "vision_model.pre_layrnorm."},  // written so
    {"visual.ln_post.", "vision_model.post_layernorm."},
    {kOutput, "visual_projection.weight"},
    {"visual.transformer.resblocks.", "vision_model.encoder.layers."},
    {"attn.", "self_attn."},
    {".ln_", ".layer_norm"},
    {"mlp.c_fc.", "mlp.fc1."},
    {"mlp.c_proj.", "mlp.fc2."},
}};

std::string transformers_name(std::string name) {
  for (const auto& [from, to] : kTransformers) {
    const std::size_t at = name.find(from);
    if (at != std::string::npos) name.replace(at, from.size(), to);
  }
  return name;
}

// Queries, keys and values are three arrays there.
std::vector<core::ArraySpec> parts_of(const core::ArraySpec& array) {
  const std::string name = transformers_name(array.name);
  constexpr std::string_view kJoined = "in_proj_";
  const std::size_t at = name.find(kJoined);
  std::vector<std::int64_t> shape = array.shape;
  if (at == std::string::npos) {
    if (array.name == kOutput) std::ranges::reverse(shape);
    return {{name, shape}};
  }
  shape[0] /= 3;
  std::vector<core::ArraySpec> parts;
  for (const char part : {'q', 'k', 'v'}) {
    parts.push_back(
        {fmt::format("{}{}_proj.{}", name.substr(0, at), part, name.substr(at + kJoined.size())),
         shape});
  }
  return parts;
}

// The same weights by OpenAI's names.
core::Weights read_transformers(const TensorFile& file, std::span<const core::ArraySpec> wanted) {
  std::vector<core::ArraySpec> all;
  for (const core::ArraySpec& array : wanted)
    std::ranges::copy(parts_of(array), std::back_inserter(all));
  const core::Weights found = core::read_weights(file, all, is_of_text_in_transformers);
  core::Weights weights;
  for (const core::ArraySpec& array : wanted) {
    std::vector<at::Tensor> parts;
    for (const core::ArraySpec& part : parts_of(array)) parts.push_back(found.at(part.name));
    at::Tensor joined = parts.size() == 1 ? parts[0] : at::cat(parts);
    if (array.name == kOutput) joined = joined.t().contiguous();
    weights[array.name] = joined;
  }
  return weights;
}

core::Weights read_clip(const std::filesystem::path& path,
                        std::span<const core::ArraySpec> wanted) {
  const TensorFile file = TensorFile::open(path);
  const bool transformers = std::ranges::any_of(file.arrays(), [](const auto& array) {
    return features::bare_name(array.name).starts_with("vision_model.");
  });
  return transformers ? read_transformers(file, wanted)
                      : core::read_weights(file, wanted, is_of_text);
}

// As timm's vit_base_patch16_224: its sizes, its names, its pictures. HAMT and DUET ran it so.
constexpr TransformerSizes kVitB16{};
constexpr std::int64_t kClasses = 1000;  // of ImageNet
constexpr render::Normalisation kHalves{{0.5F, 0.5F, 0.5F}, {0.5F, 0.5F, 0.5F}};

TransformerNames vit_names() {
  return {.class_token = "cls_token",
          .positions = "pos_embed",
          .patches = "patch_embed.proj",
          .before = {},
          .after = "norm",
          .block = "blocks.{}.",
          .norm1 = "norm1",
          .qkv_weight = "attn.qkv.weight",
          .qkv_bias = "attn.qkv.bias",
          .proj = "attn.proj",
          .norm2 = "norm2",
          .fc1 = "mlp.fc1",
          .fc2 = "mlp.fc2"};
}

// The classifier, where no class scores are asked for.
bool is_head(std::string_view name) { return name.starts_with("head."); }

}  // namespace

std::unique_ptr<ImageEncoder> make_clip(const EncoderConfig& config) {
  const c10::Device device = core::open_device(config.device);
  TransformerParts parts;
  parts.sizes = sizes_of(config.name);
  const std::vector<core::ArraySpec> wanted = clip_arrays(parts.sizes);
  const core::Weights weights = config.weights.empty() ? random_transformer(wanted, config.seed)
                                                       : read_clip(config.weights, wanted);
  parts.arrays = arrays_of(clip_names(), parts.sizes, weights);
  parts.preprocessing = "clip";
  parts.shorter = 224;
  parts.normalisation = kClip;
  parts.output = {weights.at(kOutput).t(), {}};
  parts.hash = core::hash_of(weights);
  return make_transformer_encoder(std::move(parts), device);
}

std::unique_ptr<ImageEncoder> make_vit(const EncoderConfig& config) {
  const c10::Device device = core::open_device(config.device);
  std::vector<core::ArraySpec> wanted = transformer_arrays(vit_names(), kVitB16);
  if (config.logits) {
    wanted.push_back({"head.weight", {kClasses, kVitB16.width}});
    wanted.push_back({"head.bias", {kClasses}});
  }
  const core::Weights weights =
      config.weights.empty() ? random_transformer(wanted, config.seed)
                             : core::read_weights(features::TensorFile::open(config.weights),
                                                  wanted, config.logits ? core::nothing : is_head);
  TransformerParts parts;
  parts.sizes = kVitB16;
  parts.arrays = arrays_of(vit_names(), kVitB16, weights);
  parts.preprocessing = "vit";
  parts.shorter = 248;  // 224 pixels are 90 % of it
  parts.normalisation = kHalves;
  parts.beside = config.logits;
  if (config.logits) parts.output = {weights.at("head.weight"), weights.at("head.bias")};
  parts.hash = core::hash_of(weights);
  return make_transformer_encoder(std::move(parts), device);
}

}  // namespace enfilade::neural::encoders
