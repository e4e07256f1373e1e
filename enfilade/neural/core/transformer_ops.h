/// \file  The operations of a transformer beside its products, each as one: on the CPU half of the
/// time goes to PyTorch's many small ones. Gradients flow through them; those of gradients do not.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>

namespace enfilade::neural::core {

/// softmax(query key^T / sqrt(width) + bias) value, head by head.
/// \param query (n, a, heads * width) \param key, value (n, b, heads * width)
/// \param bias (1 or n, 1, 1 or a, b); undefined: none
/// \param kept factors of the shares, of Dropout::mask(), (n, heads, a, b); undefined: 1
/// \return (n, a, heads * width)
at::Tensor attend(const at::Tensor& query, const at::Tensor& key, const at::Tensor& value,
                  const at::Tensor& bias, const at::Tensor& kept, std::int64_t heads);
/// The same with PyTorch's operations: on any device and of any type. Reference of the tests.
at::Tensor attend_by_parts(const at::Tensor& query, const at::Tensor& key, const at::Tensor& value,
                           const at::Tensor& bias, const at::Tensor& kept, std::int64_t heads);

/// The same in one operation, for cards, which draw what they drop by themselves as Dropout does.
/// \param rate share of the shares that become 0
at::Tensor attend_on_card(const at::Tensor& query, const at::Tensor& key, const at::Tensor& value,
                          const at::Tensor& bias, double rate, std::int64_t heads);

/// The layer norm of kept y + x over the last dimension, times `scale`, plus `bias`.
/// \param y, x (..., width); x undefined: 0 \param kept as y; undefined: 1
/// \param epsilon added to the variance
at::Tensor sum_norm(const at::Tensor& y, const at::Tensor& x, const at::Tensor& kept,
                    const at::Tensor& scale, const at::Tensor& bias, double epsilon);
/// The same of PyTorch's operations.
at::Tensor sum_norm_by_parts(const at::Tensor& y, const at::Tensor& x, const at::Tensor& kept,
                             const at::Tensor& scale, const at::Tensor& bias, double epsilon);

/// x Phi(x), Phi that of the normal distribution, to 2e-7 |x|.
at::Tensor gelu(const at::Tensor& x);

/// x weight^T + bias. If both are leaves, their gradients are added in place in the backward pass.
/// Many steps share the weights, and a product adds at no cost what takes a pass over memory
/// otherwise. Two threads may not run backward passes to the same leaves.
/// \param x (..., inner) \param weight (width, inner) \param bias (width); undefined: none
at::Tensor linear(const at::Tensor& x, const at::Tensor& weight, const at::Tensor& bias = {});

}  // namespace enfilade::neural::core
