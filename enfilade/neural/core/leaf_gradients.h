/// \file  Gradients of leaves that autograd adds in place in the backward pass. Many steps share
/// the weights, and a product adds at no cost what takes a pass over memory otherwise.
#pragma once
#include <ATen/ATen.h>

namespace enfilade::neural::core {

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
