#include "enfilade/neural/encoders/transformer_encoder.h"

#include <ATen/ATen.h>
#include <c10/core/InferenceMode.h>
#include <fmt/format.h>
#include <algorithm>
#include <optional>
#include <utility>

#include "enfilade/neural/core/random_weights.h"
#include "enfilade/neural/encoders/encoder_input.h"
#include "enfilade/neural/encoders/picture_resize.h"

namespace enfilade::neural::encoders {
namespace {

constexpr double kBrightest = 255;

at::Tensor channels(const std::array<float, 3>& numbers, c10::Device device) {
  return at::tensor(at::ArrayRef<float>(numbers)).view({3, 1, 1}).to(device);
}

class TransformerEncoder final : public ImageEncoder {
 public:
  TransformerEncoder(TransformerParts parts, c10::Device device)
      : network_(parts.sizes, parts.arrays, device),
        side_(static_cast<std::uint32_t>(parts.sizes.picture)),
        shorter_(parts.preparation.shorter),
        mean_(channels(parts.preparation.normalisation.mean, device)),
        deviation_(channels(parts.preparation.normalisation.deviation, device)),
        preprocessing_(std::move(parts.preparation.name)),
        output_(std::move(parts.output)),
        beside_(parts.beside),
        hash_(std::move(parts.hash)) {
    const std::int64_t outputs = output_.weight.defined() ? output_.weight.size(0) : 0;
    const bool token = beside_ || outputs == 0;
    dimensions_ = static_cast<std::size_t>((token ? parts.sizes.width : 0) + outputs);
    if (output_.weight.defined()) output_.weight = output_.weight.to(device);
    if (output_.bias.defined()) output_.bias = output_.bias.to(device);
  }

  std::size_t dimensions() const override { return dimensions_; }
  Camera camera() const override { return {640, 480, degrees(60)}; }
  // Resized on the host, whatever computes.
  std::span<float> memory(std::size_t n, const Camera& camera) override {
    return input_.take(n, camera);
  }
  bool on_card() const override { return false; }
  std::string weights_hash() const override { return hash_; }
  std::string preprocessing() const override { return preprocessing_; }

  // Whole numbers from 0 to 255: resizing rounds to them.
  render::Normalisation normalisation() const override {
    constexpr auto kStep = static_cast<float>(1 / kBrightest);
    return {{0, 0, 0}, {kStep, kStep, kStep}};
  }

  void encode(std::span<const float> pictures, std::size_t n, const Camera& camera,
              std::span<float> features) override {
    check_sizes(pictures.size(), n, camera, dimensions(), features.size());
    if (n == 0) return;
    if (!resize_ || resize_->from() != camera) resize_.emplace(camera, shorter_, side_);
    const c10::InferenceMode no_gradients;
    at::Tensor seen = resize_->apply(pictures, n).to(network_.device());
    seen.div_(kBrightest).sub_(mean_).div_(deviation_);
    const at::Tensor output = finish(network_.run(seen)).cpu().contiguous();
    std::ranges::copy_n(output.data_ptr<float>(), output.numel(), features.begin());
  }

 private:
  at::Tensor finish(const at::Tensor& tokens) const {
    if (!output_.weight.defined()) return tokens;
    const at::Tensor output = apply(output_, tokens);
    return beside_ ? at::cat({tokens, output}, 1) : output;
  }

  VisionTransformer network_;
  std::uint32_t side_, shorter_;
  at::Tensor mean_, deviation_;
  std::string preprocessing_;
  Linear output_;
  bool beside_;
  std::string hash_;
  std::size_t dimensions_ = 0;
  std::optional<PictureResize> resize_;
  PictureMemory input_{c10::kCPU};
};

std::string block_name(const TransformerNames& names, std::int64_t block) {
  return fmt::format(fmt::runtime(names.block), block);
}

}  // namespace

std::vector<core::ArraySpec> transformer_arrays(const TransformerNames& names,
                                                const TransformerSizes& sizes) {
  const std::int64_t width = sizes.width, hidden = sizes.hidden;
  std::vector<core::ArraySpec> arrays{{names.class_token, {width}},
                                      {names.positions, {sizes.tokens(), width}}};
  if (names.leading_ones) {
    arrays[0].shape = {1, 1, width};
    arrays[1].shape = {1, sizes.tokens(), width};
  }
  const auto add = [&](const std::string& name, std::vector<std::int64_t> shape) {
    const std::int64_t out = shape[0];
    arrays.push_back({name + ".weight", std::move(shape)});
    arrays.push_back({name + ".bias", {out}});
  };
  add(names.patches, {width, 3, sizes.patch, sizes.patch});
  if (!names.patch_bias) arrays.pop_back();
  if (!names.before.empty()) add(names.before, {width});
  for (std::int64_t i = 0; i < sizes.layers; ++i) {
    const std::string block = block_name(names, i);
    add(block + names.norm1, {width});
    arrays.push_back({block + names.qkv_weight, {3 * width, width}});
    arrays.push_back({block + names.qkv_bias, {3 * width}});
    add(block + names.proj, {width, width});
    add(block + names.norm2, {width});
    add(block + names.fc1, {hidden, width});
    add(block + names.fc2, {width, hidden});
  }
  add(names.after, {width});
  return arrays;
}

TransformerArrays arrays_of(const TransformerNames& names, const TransformerSizes& sizes,
                            const core::Weights& weights) {
  const auto linear = [&](const std::string& name) {
    return Linear{weights.at(name + ".weight"), weights.at(name + ".bias")};
  };
  const auto norm = [&](const std::string& name) {
    return LayerNorm{weights.at(name + ".weight"), weights.at(name + ".bias")};
  };
  TransformerArrays arrays;
  arrays.patches.weight = weights.at(names.patches + ".weight").flatten(1);
  if (names.patch_bias) arrays.patches.bias = weights.at(names.patches + ".bias");
  arrays.class_token = weights.at(names.class_token).view({sizes.width});
  arrays.positions = weights.at(names.positions).view({sizes.tokens(), sizes.width});
  if (!names.before.empty()) arrays.before = norm(names.before);
  for (std::int64_t i = 0; i < sizes.layers; ++i) {
    const std::string block = block_name(names, i);
    const Linear qkv{weights.at(block + names.qkv_weight), weights.at(block + names.qkv_bias)};
    arrays.blocks.push_back({norm(block + names.norm1), qkv, linear(block + names.proj),
                             norm(block + names.norm2), linear(block + names.fc1),
                             linear(block + names.fc2)});
  }
  arrays.after = norm(names.after);
  return arrays;
}

std::unique_ptr<ImageEncoder> make_transformer_encoder(TransformerParts parts, c10::Device device) {
  return std::make_unique<TransformerEncoder>(std::move(parts), device);
}

core::Weights random_transformer(std::span<const core::ArraySpec> arrays, std::uint64_t seed) {
  constexpr double kDeviation = 0.02;
  core::Weights weights;
  Rng rng(seed);
  for (const core::ArraySpec& array : arrays) {
    const bool bias = array.name.ends_with("bias");
    const bool norm = array.shape.size() == 1 && array.name.ends_with(".weight");
    weights[array.name] = bias   ? at::zeros(array.shape)
                          : norm ? at::ones(array.shape)
                                 : core::normal(array.shape, kDeviation, rng);
  }
  return weights;
}

}  // namespace enfilade::neural::encoders
