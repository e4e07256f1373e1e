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

/// The pictures as (n, 3, height, width), a view of the caller's memory of the host.
at::Tensor picture_tensor(std::span<const float> pictures, std::size_t n, const Camera& camera);

/// The memory of ImageEncoder::memory().
class PictureMemory {
 public:
  explicit PictureMemory(c10::Device device) : device_(device) {}
  bool on_card() const { return !device_.is_cpu(); }
  std::span<float> take(std::size_t n, const Camera& camera);
  /// picture_tensor(), also of what take() gave.
  at::Tensor tensor(std::span<const float> pictures, std::size_t n, const Camera& camera) const;

 private:
  c10::Device device_;
  at::Tensor memory_;
};

}  // namespace enfilade::neural::encoders
