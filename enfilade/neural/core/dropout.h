/// \file  Dropout on libtorch's tensors, by a seed of its own.
#pragma once
#include <ATen/core/Tensor.h>
#include <c10/core/Device.h>
#include <cstdint>

#include "enfilade/core/rng.h"

namespace enfilade::neural::core {

/// Sets a random part of the numbers to 0 and scales up the rest. The same seed and calls give the
/// same masks on the same kind of device. A card draws by itself, as masks are as large as what
/// they drop, from libtorch's generator: one Dropout of a card at a time. One thread at a time.
class Dropout {
 public:
  explicit Dropout(std::uint64_t seed, c10::Device device = c10::kCPU);
  /// \param rate share of numbers that become 0, below 1, to the nearest 1 / 65,536; at 0 or below
  /// nothing is drawn
  at::Tensor operator()(const at::Tensor& values, double rate);
  /// The factors by which the operator multiplies numbers of these sizes: 0 or 1 / (1 - rate);
  /// float32. Undefined where nothing is drawn. \pre on the CPU
  at::Tensor mask(at::IntArrayRef sizes, double rate);

 private:
  Rng rng_;
  c10::Device device_;
};

}  // namespace enfilade::neural::core
