/// \file  Splits a row of a picture into stretches on one face each.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "enfilade/geometry/cube_map.h"

namespace enfilade::render::cpu {

/// A row's pixels as a face sees them. For column j, with D = d0 + j d1, the pixel's point on the
/// face's plane is ((s0 + j s1) / D, (t0 + j t1) / D), each in [-1, 1] if the face is met, and D is
/// positive. Single precision: what all kernels compute with, so that they agree to the bit.
struct FaceLine {
  float s0, s1, t0, t1, d0, d1;
};
using FaceLines = std::array<FaceLine, kCubeFaces>;

FaceLines face_lines(const PixelRays& rays, std::uint32_t row);

struct Stretch {
  std::uint32_t begin, end;  ///< columns, end excluded
  CubeFace face;
};

/// project_to_cube() for a whole row: stretches from left to right that cover it, found from where
/// the row's line crosses from face to face instead of pixel by pixel.
class RowPlan {
 public:
  RowPlan() = default;
  RowPlan(const PixelRays& rays, std::uint32_t row, std::uint32_t width);
  std::span<const Stretch> stretches() const noexcept { return {stretches_.data(), count_}; }

 private:
  void add_piece(const PixelRays& rays, std::uint32_t row, std::uint32_t begin, std::uint32_t end);
  void add(std::uint32_t begin, std::uint32_t end, CubeFace face);

  // A straight line meets each face at most once, but rounding may let two faces alternate where
  // a row runs along their edge: at most three for each of the 7 pieces between 6 crossings.
  std::array<Stretch, 24> stretches_;  // the first count_ are set
  std::size_t count_ = 0;
};

}  // namespace enfilade::render::cpu
