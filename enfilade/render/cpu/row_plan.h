/// \file  Splits the rows of a picture into stretches on one face each.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "enfilade/geometry/cube_map.h"

namespace enfilade::render::cpu {

/// A row's pixels as a face sees them. For column j, with D = d0 + j d1, the pixel's point on the
/// face is ((x0 + j x1) / D, (y0 + j y1) / D), in 65536ths of a texel from the middle of the first
/// texel of the face's border; D is positive where the face is met. Single precision: what all
/// kernels compute with, so that they agree to the bit.
struct FaceLine {
  float x0, x1, y0, y1, d0, d1;
};

/// \param rays in the panorama frame  \param size of the face, in texels
FaceLine face_line(const PixelRays& rays, std::uint32_t row, CubeFace face, std::uint32_t size);

struct Stretch {
  std::uint32_t begin, end;  ///< columns, end excluded
  CubeFace face;
};

/// The stretches of one row, from left to right.
class Stretches {
 public:
  static constexpr std::size_t kMost = 7;  ///< pieces between six crossings
  std::span<const Stretch> all() const noexcept { return {stretches_.data(), count_}; }

 private:
  friend class ViewPlan;
  void add(std::uint32_t begin, std::uint32_t end, CubeFace face);

  std::array<Stretch, kMost> stretches_;  // the first count_ are set
  std::size_t count_ = 0;
};

/// Where the faces of a cube are in a picture. Faces meet in straight lines, six at most, so a row
/// crosses them at columns that are linear in its number.
class ViewPlan {
 public:
  explicit ViewPlan(const PixelRays& rays);
  /// project_to_cube() for a whole row: stretches that cover columns 0 .. width - 1.
  void plan(std::uint32_t row, std::uint32_t width, Stretches& out) const;

 private:
  // Rows begin .. end - 1.
  struct Rows {
    std::uint32_t begin = 0, end = 0;
    bool have(std::uint32_t row) const noexcept { return row >= begin && row < end; }
  };

  // The columns origin + row * slope at which two parts of the direction are of equal size, and the
  // rows in which the third part is not larger: in the others no face ends there.
  struct Crossing {
    double origin, slope;
    std::array<Rows, 2> rows;
  };

  static std::array<Rows, 2> rows_within(double part0, double part1, double limit0, double limit1);

  PixelRays rays_;
  std::array<Crossing, 6> crossings_;  // the first count_ are set
  std::size_t count_ = 0;
};

}  // namespace enfilade::render::cpu
