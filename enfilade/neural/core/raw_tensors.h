/// \file  Tensors as loops of our own see them.
#pragma once
#include <ATen/ATen.h>
#include <ATen/core/Tensor.h>
#include <cstddef>
#include <cstdint>

namespace enfilade::neural::core {

/// The numbers of a contiguous tensor of float32; null if it is undefined.
inline float* numbers(const at::Tensor& x) { return x.defined() ? x.data_ptr<float>() : nullptr; }

/// A size of a tensor as one of memory. \pre n >= 0
inline std::size_t size(std::int64_t n) { return static_cast<std::size_t>(n); }

/// Whether these functions may be used for a weight.
inline bool adds_in_place(const at::Tensor& weight) {
  return weight.is_leaf() && weight.requires_grad();
}

/// a b is added to the gradient.
inline void add_product(const at::Tensor& leaf, const at::Tensor& a, const at::Tensor& b) {
  at::Tensor& sum = at::Tensor(leaf).mutable_grad();
  if (sum.defined()) {
    sum.addmm_(a, b);
  } else {
    sum = at::mm(a, b);
  }
}

/// `part`, of the leaf's shape, is added to the gradient.
inline void add_sum(const at::Tensor& leaf, const at::Tensor& part) {
  at::Tensor& sum = at::Tensor(leaf).mutable_grad();
  if (sum.defined()) {
    sum.add_(part);
  } else {
    sum = part.clone();
  }
}

}  // namespace enfilade::neural::core
