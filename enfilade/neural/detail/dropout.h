/// \file  Dropout on libtorch's tensors, by a seed of its own.
#pragma once
#include <ATen/core/Generator.h>
#include <ATen/core/Tensor.h>
#include <cstdint>

namespace enfilade::neural::detail {

/// Sets a random part of the numbers to 0 and scales up the rest. The same seed and calls give the
/// same masks. One thread at a time.
class Dropout {
 public:
  explicit Dropout(std::uint64_t seed);
  /// \param rate share of numbers that become 0, below 1; at 0 or below nothing is drawn
  at::Tensor operator()(const at::Tensor& values, double rate);

 private:
  at::Generator generator_;
};

}  // namespace enfilade::neural::detail
