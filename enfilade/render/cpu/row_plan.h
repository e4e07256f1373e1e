/// \file  Splits the rows of a picture into stretches on one face each.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "enfilade/geometry/cube_map.h"
#include "enfilade/render/detail/pixels.h"

namespace enfilade::render::cpu {

namespace pixels = detail::pixels;
using pixels::FaceLine;

/// As pixels.h has them.
inline pixels::Vector plain(Vec3d v) { return {v.x, v.y, v.z}; }
inline pixels::Rays plain(const PixelRays& rays) {
  return {plain(rays.origin), plain(rays.row), plain(rays.column)};
}

/// \param rays in the panorama frame  \param size of the face, in texels
inline FaceLine face_line(const PixelRays& rays, std::uint32_t row, CubeFace face,
                          std::uint32_t size) {
  return pixels::face_line(plain(rays), row, static_cast<std::uint32_t>(index(face)), size);
}

using pixels::Stretch;
inline CubeFace face_of(const Stretch& stretch) { return cube_face(stretch.face); }

/// The stretches of one row, from left to right.
class Stretches {
 public:
  static constexpr std::size_t kMost = pixels::kMostStretches;
  std::span<const Stretch> all() const noexcept { return {stretches_.data(), count_}; }

 private:
  friend class ViewPlan;

  std::array<Stretch, kMost> stretches_;  // the first count_ are set
  std::size_t count_ = 0;
};

/// Where the faces of a cube are in a picture. Faces meet in straight lines, six at most, so a row
/// crosses them at columns that are linear in its number.
class ViewPlan {
 public:
  explicit ViewPlan(const PixelRays& rays);
  /// project_to_cube() for a whole row: stretches that cover columns 0 .. width - 1.
  void plan(std::uint32_t row, std::uint32_t width, Stretches& out) const {
    out.count_ = 0;
    pixels::plan_row(crossings_.data(), rays_, row, width,
                     [&](const Stretch& stretch) { out.stretches_[out.count_++] = stretch; });
  }

 private:
  pixels::Rays rays_;
  std::array<pixels::Crossing, pixels::kCrossings> crossings_;
};

}  // namespace enfilade::render::cpu
