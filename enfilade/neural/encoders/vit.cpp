#include <ATen/ATen.h>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/neural/core/torch_device.h"
#include "enfilade/neural/encoders/make_encoders.h"
#include "enfilade/neural/encoders/transformer_encoder.h"

namespace enfilade::neural::encoders {
namespace {

// As timm's vit_base_patch16_224: its sizes, its names, its pictures. HAMT and DUET ran it so.
constexpr TransformerSizes kVitB16{};
constexpr std::int64_t kClasses = 1000;     // of ImageNet
constexpr std::uint32_t kVitShorter = 248;  // 224 pixels are 90 % of it
constexpr render::Normalisation kHalves{{0.5F, 0.5F, 0.5F}, {0.5F, 0.5F, 0.5F}};

TransformerNames vit_names() {
  TransformerNames names;
  names.class_token = "cls_token";
  names.positions = "pos_embed";
  names.patches = "patch_embed.proj";
  names.block = "blocks.{}.";
  names.norm1 = "norm1";
  names.qkv_weight = "attn.qkv.weight";
  names.qkv_bias = "attn.qkv.bias";
  names.proj = "attn.proj";
  names.norm2 = "norm2";
  names.fc1 = "mlp.fc1";
  names.fc2 = "mlp.fc2";
  names.after = "norm";
  return names;
}

// The classifier, where no class scores are asked for.
bool is_head(std::string_view name) { return name.starts_with("head."); }
bool has_no_surplus(std::string_view /*name*/) { return false; }

}  // namespace

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
                                                  wanted, config.logits ? has_no_surplus : is_head);
  TransformerParts parts;
  parts.sizes = kVitB16;
  parts.arrays = arrays_of(vit_names(), kVitB16, weights);
  parts.preparation = {"vit", kVitShorter, kHalves};
  parts.beside = config.logits;
  if (config.logits) parts.output = {weights.at("head.weight"), weights.at("head.bias")};
  parts.hash = core::hash_of(weights);
  return make_transformer_encoder(std::move(parts), device);
}

}  // namespace enfilade::neural::encoders
