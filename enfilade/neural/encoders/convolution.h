/// \file  Convolutions as networks in evaluation have them: batch normalisation folded in.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>

namespace enfilade::neural::encoders {

struct Convolution {
  at::Tensor weight;  ///< (out, in, k, k)
  at::Tensor bias;    ///< (out)
  std::int64_t stride = 1, padding = 0, dilation = 1;
};

/// A batch normalisation after training: four arrays of one size.
struct BatchNorm {
  at::Tensor weight, bias, mean, variance;
};
inline constexpr double kBatchNormEpsilon = 1e-5;  ///< PyTorch's default, which torchvision keeps

/// Makes `convolution` (without bias) do what it and then `norm` would. Worked out in double, so
/// that the result differs from the two steps by their own rounding only.
void fold(const BatchNorm& norm, Convolution& convolution);

/// How numbers lie in memory while a network runs.
enum class Layout {
  kOneDnn,        ///< oneDNN's own, in blocks of channels: the fastest on processors
  kChannelsLast,  ///< what graphics cards like best
};
Layout best_layout(c10::Device device);

/// Lays out weights for a device, once.
void prepare(Convolution& convolution, c10::Device device, Layout layout);
/// Pictures (n, 3, h, w) of this thread's memory on the device and in that layout.
at::Tensor prepare(const at::Tensor& pictures, c10::Device device, Layout layout);

/// \pre both went through prepare() with the same layout
at::Tensor apply(const Convolution& convolution, const at::Tensor& x);

}  // namespace enfilade::neural::encoders
