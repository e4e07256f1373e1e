/// \file  Random initial weights.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstdint>
#include <vector>

#include "enfilade/core/rng.h"

namespace enfilade::neural::core {

/// Normal distribution around 0, the same on every platform up to the rounding of std::log and
/// std::cos.
at::Tensor normal(const std::vector<std::int64_t>& shape, double deviation, Rng& rng);

/// For a convolution (out, in, k, k) that a ReLU follows (He et al. 2015, forward).
at::Tensor he_normal(const std::vector<std::int64_t>& shape, Rng& rng);

}  // namespace enfilade::neural::core
