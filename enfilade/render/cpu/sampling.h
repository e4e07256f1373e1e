/// \file  One texel lookup, in the arithmetic that all kernels share; see docs/design/kernels.md.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "enfilade/render/cpu/row_plan.h"
#include "enfilade/render/face_cache.h"

namespace enfilade::render::cpu {

/// A point of a face in 32768ths of a texel from its top left corner, 0 .. size << 15: a texel's
/// number and the place in it are the upper and the lower bits of one whole number.
struct TexelPoint {
  std::int32_t x, y;
};

inline TexelPoint texel_point(const FaceLine& line, std::uint32_t size, std::uint32_t column) {
  const float j = static_cast<float>(column);
  const float half = static_cast<float>(size) * 16384.0F, whole = half + half;
  const float ratio = half / (line.d0 + j * line.d1);
  const float x = (line.s0 + j * line.s1) * ratio + half;
  const float y = (line.t0 + j * line.t1) * ratio + half;
  // Values outside this range are rounding errors.
  return {static_cast<std::int32_t>(std::min(std::max(x, 0.0F), whole)),
          static_cast<std::int32_t>(std::min(std::max(y, 0.0F), whole))};
}

/// From texels' corners to their middles, and on to the border's first texel: what turns a point
/// into the number of the left or upper of two texels, plus 1, and its weight.
inline constexpr std::int32_t kLinearShift = 16384;

/// What the shifted numbers are held to. Clamped: not beyond the middles of the outer texels.
struct LinearRange {
  std::int32_t low, high;
};
inline LinearRange linear_range(std::uint32_t size, bool clamped) {
  const auto whole = static_cast<std::int32_t>(size << 15);
  return clamped ? LinearRange{32768, whole} : LinearRange{0, whole + kLinearShift};
}

/// The texel (-1, -1), where the shifted numbers begin.
inline const std::uint8_t* border_origin(const Face& face) { return face.origin - face.stride - 4; }

/// (a * b) / 2^15, rounded to nearest: what one vector instruction does to 16-bit numbers.
inline std::int32_t scale15(std::int32_t a, std::int32_t b) { return (a * b + (1 << 14)) >> 15; }

/// a + (b - a) * weight / 2^15; a and b in 64ths of a level.
inline std::int32_t mix15(std::int32_t a, std::int32_t b, std::int32_t weight) {
  return a + scale15(b - a, weight);
}

/// Bilinear; the texels around come from the face's border. RGBA in memory order, A = 255.
inline std::uint32_t sample_colour(const Face& face, LinearRange range, TexelPoint p) {
  const std::int32_t x = std::clamp(p.x + kLinearShift, range.low, range.high);
  const std::int32_t y = std::clamp(p.y + kLinearShift, range.low, range.high);
  const std::int32_t wx = x & 32767, wy = y & 32767;
  const std::uint8_t* top = border_origin(face) + static_cast<std::size_t>(y >> 15) * face.stride +
                            static_cast<std::size_t>(x >> 15) * 4;
  const std::uint8_t* bottom = top + face.stride;
  std::uint32_t rgba = 0;
  for (unsigned c = 0; c < 4; ++c) {
    const std::int32_t left = mix15(top[c] << 6, bottom[c] << 6, wy);
    const std::int32_t right = mix15(top[c + 4] << 6, bottom[c + 4] << 6, wy);
    const std::int32_t value = (mix15(left, right, wx) + 32) >> 6;
    rgba |= static_cast<std::uint32_t>(value) << (8 * c);
  }
  return rgba;
}

/// The texel that holds the point.
template <class T>
T sample_nearest(const Face& face, TexelPoint p) {
  const auto last = static_cast<std::int32_t>(face.size << 15) - 1;
  const auto x = static_cast<std::size_t>(std::min(p.x, last) >> 15);
  const auto y = static_cast<std::size_t>(std::min(p.y, last) >> 15);
  T value;
  std::memcpy(&value, face.origin + y * face.stride + x * sizeof(T), sizeof(T));
  return value;
}

}  // namespace enfilade::render::cpu
