/// \file  Splits the rows of a picture into stretches on one face each. Looks up single texels, in
/// the arithmetic that all kernels share; see docs/design/kernels.md.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "enfilade/geometry/cube_map.h"
#include "enfilade/image/face_cells.h"
#include "enfilade/render/detail/pixels.h"
#include "enfilade/render/face_cache.h"

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

using pixels::RowStretch;
inline CubeFace face_of(const RowStretch& stretch) { return cube_face(stretch.face); }

/// The stretches of one row, from left to right.
class Stretches {
 public:
  static constexpr std::size_t kMost = pixels::kMostStretches;
  std::span<const RowStretch> all() const noexcept { return {stretches_.data(), count_}; }

 private:
  friend class ViewPlan;

  std::array<RowStretch, kMost> stretches_;  // the first count_ are set
  std::size_t count_ = 0;
};

/// Where the faces of a cube are in a picture. Faces meet in straight lines, six at most, so a row
/// crosses them at columns that are linear in its number.
class ViewPlan {
 public:
  explicit ViewPlan(const PixelRays& rays) : rays_(plain(rays)) {
    for (std::uint32_t k = 0; k < pixels::kCrossings; ++k) {
      crossings_[k] = pixels::find_crossing(rays_, k);
    }
  }
  /// project_to_cube() for a whole row: stretches that cover columns 0 .. width - 1.
  void plan(std::uint32_t row, std::uint32_t width, Stretches& out) const {
    out.count_ = 0;
    pixels::plan_row(crossings_.data(), rays_, row, width,
                     [&](const RowStretch& stretch) { out.stretches_[out.count_++] = stretch; });
  }

 private:
  pixels::Rays rays_;
  std::array<pixels::Crossing, pixels::kCrossings> crossings_;
};

using pixels::kWholeWeight;
using pixels::scale15;
using pixels::TexelPoint;

inline TexelPoint texel_point(const FaceLine& line, std::uint32_t column) {
  return pixels::texel_point(line, static_cast<float>(column));
}

/// The colour texels around a point, and how to weigh them.
struct Tap {
  std::int32_t offset;  ///< bytes from the face's cells to the left upper texel.
  /// Bits 0-7 and 8-15: weights of the left and the right texels, 255 in all. Bits 16-31: weight of
  /// the lower texels in 2^-15, times 128 / 255, of kWholeWeight in all.
  std::uint32_t weights;
};

/// Converts columns to strips: x / 18 = x * 3641 / 65536 for all x up to kLargestCellFace.
inline constexpr std::int32_t kStripFactor = 3641;
/// Bytes from the end of a strip's first line of 18 texels to the next strip's.
inline std::int32_t strip_step(std::uint32_t size) {
  return static_cast<std::int32_t>(image::ColourCells::pitch(size)) -
         static_cast<std::int32_t>(image::ColourCells::kColumns * image::ColourCells::kTexelBytes);
}

/// Clamped: no farther than to the middles of the outer texels.
inline Tap tap_at(std::uint32_t size, bool clamped, TexelPoint p) {
  if (clamped) p = pixels::clamped(p, size);
  const std::int32_t x = p.x >> 16, y = p.y >> 16;
  const std::int32_t strip = x * kStripFactor >> 16;
  const std::uint32_t right = pixels::right_weight(p), below = pixels::lower_weight(p);
  return {strip * strip_step(size) + 3 * x + 64 * y, below << 16 | right << 8 | (255 - right)};
}

/// Bilinear; the texels around come from the face's border. RGBA in memory order, A = 255.
inline std::uint32_t sample_colour(const std::uint8_t* cells, Tap tap) {
  const std::uint8_t* top = cells + tap.offset;
  const std::uint8_t* bottom = top + image::kCellBytes;
  const auto left = static_cast<std::int32_t>(tap.weights & 255);
  const auto right = static_cast<std::int32_t>(tap.weights >> 8 & 255);
  const auto below = static_cast<std::int32_t>(tap.weights >> 16);
  const auto mix = [&](const std::uint8_t* texels, unsigned c) {
    // Cells have texels less 128 as bytes with a sign.
    return static_cast<std::int8_t>(texels[c]) * left +
           static_cast<std::int8_t>(texels[c + 3]) * right;
  };
  std::uint32_t rgba = 0xFF000000U;
  for (unsigned c = 0; c < 3; ++c) {
    const std::int32_t value =
        scale15(mix(top, c), kWholeWeight - below) + scale15(mix(bottom, c), below);
    rgba |= static_cast<std::uint32_t>(scale15(value, 256) + 128) << (8 * c);
  }
  return rgba;
}

/// Bytes from a face's cells to the texel that holds the point.
template <class T>
std::int32_t nearest_offset(std::uint32_t size, TexelPoint p) {
  return static_cast<std::int32_t>(image::ValueCells<T>::offset(
      size, pixels::nearest_texel(p.x, size), pixels::nearest_texel(p.y, size)));
}

template <class T>
T sample_nearest(const Face& face, TexelPoint p) {
  T value;
  std::memcpy(&value, face.cells + nearest_offset<T>(face.size, p), sizeof(T));
  return value;
}

}  // namespace enfilade::render::cpu
