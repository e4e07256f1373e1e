#include "enfilade/neural/duet/layers.h"

#include <ATen/ATen.h>

#include "enfilade/core/check.h"
#include "enfilade/neural/core/transformer_ops.h"

namespace enfilade::neural::duet {
namespace {

constexpr double kTorchEpsilon = 1e-5;  // default of torch.nn.LayerNorm

}  // namespace

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
