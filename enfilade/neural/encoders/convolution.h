/// \file  Convolutions for inference, with batch normalisation folded in.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>

namespace enfilade::neural::encoders {

/// core::Weights and settings of a convolution.
struct Convolution {
  at::Tensor weight;  ///< (out, in, k, k)
  at::Tensor bias;    ///< (out)
  std::int64_t stride = 1, padding = 0, dilation = 1;
};

/// A batch normalisation after training: four arrays of one size.
struct BatchNorm {
  at::Tensor weight, bias, mean, variance;
};
inline constexpr double kBatchNormEpsilon = 1e-5;  ///< PyTorch's default, also torchvision's

/// Changes `convolution` (without bias) to compute the same as if followed by `norm`. Computed in
/// double, so the result differs from the two steps by their own rounding only.
void fold(const BatchNorm& norm, Convolution& convolution);

/// Memory layout of activations and weights.
enum class ActivationLayout {
  kOneDnn,        ///< oneDNN's own, in blocks of channels: the fastest on CPUs
  kChannelsLast,  ///< the fastest on GPUs
};
ActivationLayout best_layout(c10::Device device);

/// Converts weights to a device and layout, once.
void prepare(Convolution& convolution, c10::Device device, ActivationLayout layout);
/// Copies pictures (n, 3, h, w) to a device and layout.
at::Tensor prepare(const at::Tensor& pictures, c10::Device device, ActivationLayout layout);

/// Applies a convolution. \pre both were prepared with the same layout
at::Tensor apply(const Convolution& convolution, const at::Tensor& x);

}  // namespace enfilade::neural::encoders
