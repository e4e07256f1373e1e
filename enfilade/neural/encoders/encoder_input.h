/// \file  Checks of an encoder's input, and the input as a tensor.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstddef>
#include <span>

#include "enfilade/geometry/camera.h"

namespace enfilade::neural::encoders {

/// \throws ArgumentError for sizes that do not fit, or pictures smaller than 32 x 32
void check_sizes(std::size_t numbers, std::size_t n, const Camera& camera, std::size_t dimensions,
                 std::size_t features);

/// The pictures as (n, 3, height, width), a view of the caller's memory.
at::Tensor picture_tensor(std::span<const float> pictures, std::size_t n, const Camera& camera);

}  // namespace enfilade::neural::encoders
