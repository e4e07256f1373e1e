/// \file  Pictures made smaller as Pillow does it, bit by bit: what Transformers were trained on.
#pragma once
#include <ATen/core/Tensor.h>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/geometry/camera.h"

namespace enfilade::neural::encoders {

/// torchvision's `Resize(shorter, BICUBIC)` of a Pillow picture, then `CenterCrop(crop)`.
/// Immutable: any thread.
class PictureResize {
 public:
  /// \param shorter the shorter side after resizing, in pixels; at least `crop`
  PictureResize(const Camera& from, std::uint32_t shorter, std::uint32_t crop);

  const Camera& from() const noexcept { return from_; }

  /// Float32 on the CPU, (n, 3, crop, crop), whole numbers from 0 to 255. Equal to Pillow's in
  /// each number: the same whole-number weights, rounded after each of the two passes.
  /// \param pictures (n, 3, height, width) of from(), whole numbers from 0 to 255
  at::Tensor apply(std::span<const float> pictures, std::size_t n) const;

 private:
  // The sources of one row or column of the result.
  struct Taps {
    std::size_t first = 0;
    std::vector<std::int32_t> weights;  // in units of 2^-22
  };
  static std::vector<Taps> taps(std::size_t from, std::size_t to, std::size_t crop);
  void resize_plane(std::span<const float> plane, std::span<float> out) const;

  Camera from_;
  std::size_t crop_;
  std::vector<Taps> columns_, rows_;
};

}  // namespace enfilade::neural::encoders
