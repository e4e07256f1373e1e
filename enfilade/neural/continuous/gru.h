/// \file  A gated recurrent unit over rows of steps, as one operation.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
#include <vector>

namespace enfilade::neural::continuous {

/// The arrays of a GRU, in PyTorch's order of gates: reset, update, new.
struct GruWeights {
  at::Tensor input;                    ///< (3 hidden, in)
  at::Tensor hidden;                   ///< (3 hidden, hidden)
  at::Tensor input_bias, hidden_bias;  ///< (3 hidden)
};

/// Steps of several rows, packed: those of all rows' first steps, then of all second steps, and so
/// on. Shorter rows come after longer ones, so that a step has the first `counts[t]` rows.
///
/// As PyTorch's `GRU`; values and gradients are the same except for rounding. Gradients flow to `x`
/// and the weights.
/// \param x (sum of counts, in) float32 on the CPU
/// \param counts from 1, never rising
/// \param before (counts[0], hidden): the state before the first step
/// \return (sum of counts, hidden): the state after each step
at::Tensor read_gru(const at::Tensor& x, const std::vector<std::int64_t>& counts,
                    const at::Tensor& before, const GruWeights& weights);

}  // namespace enfilade::neural::continuous
