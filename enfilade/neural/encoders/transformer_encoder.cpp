#include "enfilade/neural/encoders/transformer_encoder.h"

#include <ATen/ATen.h>
#include <fmt/format.h>
#include <cmath>
#include <optional>
#include <utility>

#include "enfilade/core/check.h"
#include "enfilade/neural/encoders/encoder_input.h"

namespace enfilade::neural::encoders {
namespace {

constexpr double kBrightest = 255;

at::Tensor channels(const std::array<float, 3>& numbers, c10::Device device) {
  return at::tensor(at::ArrayRef<float>(numbers)).view({3, 1, 1}).to(device);
}

class TransformerEncoder final : public CheckedEncoder {
 public:
  TransformerEncoder(TransformerParts parts, c10::Device device)
      : CheckedEncoder(c10::kCPU),  // pictures are resized on the host, whatever computes
        network_(parts.sizes, parts.arrays, device),
        parts_(std::move(parts)),
        mean_(channels(parts_.normalisation.mean, device)),
        deviation_(channels(parts_.normalisation.deviation, device)) {
    hash_ = std::move(parts_.hash);
    parts_.arrays = {};  // the network has them
    for (at::Tensor* array : {&parts_.output.weight, &parts_.output.bias}) {
      if (array->defined()) *array = array->to(device);
    }
  }

  std::size_t dimensions() const override {
    const bool output = parts_.output.weight.defined();
    return static_cast<std::size_t>((parts_.beside || !output ? parts_.sizes.width : 0) +
                                    (output ? parts_.output.weight.size(0) : 0));
  }
  Camera camera() const override { return {640, 480, degrees(60)}; }
  std::string preprocessing() const override { return parts_.preprocessing; }

  // Whole numbers from 0 to 255: resizing rounds to them.
  render::Normalisation normalisation() const override {
    constexpr auto kStep = static_cast<float>(1 / kBrightest);
    return {{0, 0, 0}, {kStep, kStep, kStep}};
  }

 private:
  at::Tensor run(std::span<const float> pictures, std::size_t n, const Camera& camera) override {
    if (!resize_ || resize_->from() != camera) {
      resize_.emplace(camera, parts_.shorter, static_cast<std::uint32_t>(parts_.sizes.picture));
    }
    at::Tensor seen = resize_->apply(pictures, n).to(network_.device());
    seen.div_(kBrightest).sub_(mean_).div_(deviation_);
    return finish(network_.run(seen));
  }

  at::Tensor finish(const at::Tensor& tokens) const {
    if (!parts_.output.weight.defined()) return tokens;
    const at::Tensor output = apply(parts_.output, tokens);
    return parts_.beside ? at::cat({tokens, output}, 1) : output;
  }

  VisionTransformer network_;
  TransformerParts parts_;
  at::Tensor mean_, deviation_;
  std::optional<PictureResize> resize_;
};

std::string block_name(const TransformerNames& names, std::int64_t block) {
  return fmt::format(fmt::runtime(names.block), block);
}

void move(at::Tensor& array, c10::Device device) {
  if (array.defined()) array = array.to(device).contiguous();
}
void move(Linear& linear, c10::Device device) {
  move(linear.weight, device);
  move(linear.bias, device);
}
void move(LayerNorm& norm, c10::Device device) {
  move(norm.weight, device);
  move(norm.bias, device);
}

at::Tensor apply(const LayerNorm& norm, const at::Tensor& x, double epsilon) {
  return at::layer_norm(x, {x.size(-1)}, norm.weight, norm.bias, epsilon);
}

// May change x.
at::Tensor activate(at::Tensor x, Activation activation) {
  if (activation == Activation::kGelu) return at::gelu_(x);
  constexpr double kSlope = 1.702;
  return x.mul_((x * kSlope).sigmoid_());
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
  core::add_layer(arrays, names.patches, {width, 3, sizes.patch, sizes.patch});
  if (!names.patch_bias) arrays.pop_back();
  if (!names.before.empty()) core::add_layer(arrays, names.before, {width});
  for (std::int64_t i = 0; i < sizes.layers; ++i) {
    const std::string block = block_name(names, i);
    core::add_layer(arrays, block + names.norm1, {width});
    arrays.push_back({block + names.qkv_weight, {3 * width, width}});
    arrays.push_back({block + names.qkv_bias, {3 * width}});
    core::add_layer(arrays, block + names.proj, {width, width});
    core::add_layer(arrays, block + names.norm2, {width});
    core::add_layer(arrays, block + names.fc1, {hidden, width});
    core::add_layer(arrays, block + names.fc2, {width, hidden});
  }
  core::add_layer(arrays, names.after, {width});
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

at::Tensor apply(const Linear& linear, const at::Tensor& x) {
  return linear.bias.defined() ? at::addmm(linear.bias, x, linear.weight.t())
                               : at::mm(x, linear.weight.t());
}

VisionTransformer::VisionTransformer(const TransformerSizes& sizes, const TransformerArrays& arrays,
                                     c10::Device device)
    : sizes_(sizes), device_(device), arrays_(arrays) {
  EN_CHECK_EQ(sizes.picture % sizes.patch, 0);
  EN_CHECK_EQ(sizes.width % sizes.heads, 0);
  EN_CHECK_EQ(static_cast<std::int64_t>(arrays.blocks.size()), sizes.layers);
  move(arrays_.patches, device);
  move(arrays_.class_token, device);
  move(arrays_.positions, device);
  for (LayerNorm* norm : {&arrays_.before, &arrays_.after}) move(*norm, device);
  for (TransformerBlock& block : arrays_.blocks) {
    for (LayerNorm* norm : {&block.norm1, &block.norm2}) move(*norm, device);
    for (Linear* linear : {&block.qkv, &block.proj, &block.fc1, &block.fc2}) move(*linear, device);
  }
}

// A convolution whose steps are as long as its window is a product of matrices.
at::Tensor VisionTransformer::embed(const at::Tensor& pictures) const {
  const std::int64_t n = pictures.size(0), p = sizes_.patch, side = sizes_.picture / p;
  const at::Tensor patches = pictures.reshape({n, 3, side, p, side, p})
                                 .permute({0, 2, 4, 1, 3, 5})
                                 .reshape({n * side * side, 3 * p * p});
  at::Tensor x = at::empty({n, sizes_.tokens(), sizes_.width}, pictures.options());
  x.select(1, 0) = arrays_.class_token;
  x.slice(1, 1) = encoders::apply(arrays_.patches, patches).view({n, side * side, sizes_.width});
  x.add_(arrays_.positions);
  return arrays_.before.weight.defined() ? apply(arrays_.before, x, sizes_.epsilon) : x;
}

// Of the first `rows` tokens, each looking at all of them: (n rows, width).
at::Tensor VisionTransformer::attend(const TransformerBlock& block, const at::Tensor& x,
                                     std::int64_t rows) const {
  const std::int64_t n = x.size(0), tokens = x.size(1), heads = sizes_.heads;
  const std::int64_t size = sizes_.width / heads;
  const at::Tensor qkv = encoders::apply(block.qkv, x.reshape({n * tokens, sizes_.width}))
                             .view({n, tokens, 3, heads, size})
                             .permute({2, 0, 3, 1, 4})
                             .contiguous();
  const auto part = [&](std::int64_t i) { return qkv[i].view({n * heads, tokens, size}); };
  const at::Tensor queries = part(0).slice(1, 0, rows) / std::sqrt(static_cast<double>(size));
  const at::Tensor shares = at::bmm(queries, part(1).transpose(1, 2)).softmax(-1);
  const at::Tensor seen = at::bmm(shares, part(2)).view({n, heads, rows, size});
  return seen.transpose(1, 2).reshape({n * rows, sizes_.width});
}

at::Tensor VisionTransformer::run(const TransformerBlock& block, const at::Tensor& x,
                                  std::int64_t rows) const {
  const std::int64_t n = x.size(0);
  const at::Tensor seen = attend(block, apply(block.norm1, x, sizes_.epsilon), rows);
  at::Tensor y = encoders::apply(block.proj, seen);
  y.add_(x.slice(1, 0, rows).reshape({n * rows, sizes_.width}));
  at::Tensor hidden = encoders::apply(block.fc1, apply(block.norm2, y, sizes_.epsilon));
  hidden = activate(std::move(hidden), sizes_.activation);
  y.add_(encoders::apply(block.fc2, hidden));
  return y.view({n, rows, sizes_.width});
}

at::Tensor VisionTransformer::run(const at::Tensor& pictures) const {
  at::Tensor x = embed(pictures);
  for (std::size_t i = 0; i < arrays_.blocks.size(); ++i) {
    const bool last = i + 1 == arrays_.blocks.size();
    x = run(arrays_.blocks[i], x, last ? 1 : sizes_.tokens());
  }
  return apply(arrays_.after, x.select(1, 0), sizes_.epsilon);
}

}  // namespace enfilade::neural::encoders
