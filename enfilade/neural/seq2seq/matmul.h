/// \file  All matrix products of the network; products.h logs them.
#pragma once
#include <ATen/ATen.h>

namespace enfilade::neural::seq2seq {

/// out = a b, all two-dimensional with one contiguous dimension; nothing is copied.
void multiply(const at::Tensor& a, const at::Tensor& b, const at::Tensor& out);
/// out += a b
void multiply_add(const at::Tensor& a, const at::Tensor& b, const at::Tensor& out);

}  // namespace enfilade::neural::seq2seq
