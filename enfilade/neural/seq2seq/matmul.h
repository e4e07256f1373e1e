/// \file  The one door that all of the network's matrix products go through; products.h counts
/// them.
#pragma once
#include <ATen/ATen.h>

namespace enfilade::neural::seq2seq {

/// out = a b, all two-dimensional views of which one dimension is contiguous; nothing is copied.
void multiply(const at::Tensor& a, const at::Tensor& b, const at::Tensor& out);
/// out += a b
void multiply_add(const at::Tensor& a, const at::Tensor& b, const at::Tensor& out);

}  // namespace enfilade::neural::seq2seq
