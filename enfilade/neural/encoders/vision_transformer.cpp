#include "enfilade/neural/encoders/vision_transformer.h"

#include <ATen/ATen.h>
#include <cmath>
#include <utility>

#include "enfilade/core/check.h"

namespace enfilade::neural::encoders {
namespace {

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
