#include "enfilade/neural/encoders/convolution.h"

#include <ATen/ATen.h>

namespace enfilade::neural::encoders {

void fold(const BatchNorm& norm, Convolution& convolution) {
  const at::Tensor scale =
      norm.weight.to(at::kDouble) / (norm.variance.to(at::kDouble) + kBatchNormEpsilon).sqrt();
  convolution.weight =
      (convolution.weight.to(at::kDouble) * scale.view({-1, 1, 1, 1})).to(at::kFloat);
  convolution.bias = (norm.bias.to(at::kDouble) - norm.mean.to(at::kDouble) * scale).to(at::kFloat);
}

ActivationLayout best_layout(c10::Device device) {
  return device.is_cpu() && at::hasMKLDNN() ? ActivationLayout::kOneDnn
                                            : ActivationLayout::kChannelsLast;
}

void prepare(Convolution& c, c10::Device device, ActivationLayout layout) {
  if (layout == ActivationLayout::kOneDnn) {
    c.weight = at::mkldnn_reorder_conv2d_weight(c.weight.to_mkldnn(), {c.padding, c.padding},
                                                {c.stride, c.stride}, {c.dilation, c.dilation});
    c.bias = c.bias.to_mkldnn();
    return;
  }
  c.weight = c.weight.to(device).contiguous(at::MemoryFormat::ChannelsLast);
  c.bias = c.bias.to(device);
}

at::Tensor prepare(const at::Tensor& pictures, c10::Device device, ActivationLayout layout) {
  if (layout == ActivationLayout::kOneDnn) return pictures.to_mkldnn();
  return pictures.to(device).contiguous(at::MemoryFormat::ChannelsLast);
}

at::Tensor apply(const Convolution& c, const at::Tensor& x) {
  return at::conv2d(x, c.weight, c.bias, {c.stride, c.stride}, {c.padding, c.padding},
                    {c.dilation, c.dilation});
}

}  // namespace enfilade::neural::encoders
