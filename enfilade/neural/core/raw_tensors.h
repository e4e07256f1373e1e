/// \file  Tensors as loops of our own see them.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstddef>
#include <cstdint>

namespace enfilade::neural::core {

/// The numbers of a contiguous tensor of float32; null if it is undefined.
inline float* numbers(const at::Tensor& x) { return x.defined() ? x.data_ptr<float>() : nullptr; }

/// A size of a tensor as one of memory. \pre n >= 0
inline std::size_t size(std::int64_t n) { return static_cast<std::size_t>(n); }

}  // namespace enfilade::neural::core
