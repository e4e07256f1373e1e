/// \file  One texel lookup, in the arithmetic that all kernels share; see docs/design/kernels.md.
#pragma once
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "enfilade/render/cpu/row_plan.h"
#include "enfilade/render/face_cache.h"

namespace enfilade::render::cpu {

/// Points on a face for the pixels of a row, in `unit` steps a texel: (0, 0) is the face's top left
/// corner, moved by `shift` texels.
struct TexelScale {
  float half, middle, low, high;
};
struct TexelPoint {
  float x, y;
};

inline TexelPoint texel_point(const FaceLine& line, const TexelScale& scale, std::uint32_t column) {
  const float j = static_cast<float>(column);
  const float ratio = scale.half / (line.d0 + j * line.d1);
  const float x = (line.s0 + j * line.s1) * ratio + scale.middle;
  const float y = (line.t0 + j * line.t1) * ratio + scale.middle;
  // Outside this range only rounding can have put it.
  return {std::min(std::max(x, scale.low), scale.high),
          std::min(std::max(y, scale.low), scale.high)};
}

/// For nearest texels: truncated, a point's numbers are its texel's.
inline TexelScale nearest_scale(std::uint32_t size) {
  const float n = static_cast<float>(size);
  return {n * 0.5F, n * 0.5F, 0, n - 1};
}

/// For linear filtering: 32768ths of a texel, counted from the middle of the border's texel -1, so
/// that the number of the left or upper texel, plus 1, and its weight are the upper and the lower
/// bits of one truncated number. Clamped: not beyond the middles of the outer texels.
inline TexelScale linear_scale(std::uint32_t size, bool clamped) {
  const float n = static_cast<float>(size), beyond = clamped ? 0.0F : 0.5F;
  return {n * 0.5F * 32768, (n + 1) * 0.5F * 32768, (1 - beyond) * 32768, (n + beyond) * 32768};
}

/// The texel (-1, -1), where the numbers of linear_scale() begin.
inline const std::uint8_t* border_origin(const Face& face) { return face.origin - face.stride - 4; }

/// (a * b) / 2^15, rounded to nearest: what one vector instruction does to 16-bit numbers.
inline std::int32_t scale15(std::int32_t a, std::int32_t b) { return (a * b + (1 << 14)) >> 15; }

/// a + (b - a) * weight / 2^15; a and b in 64ths of a level.
inline std::int32_t mix15(std::int32_t a, std::int32_t b, std::int32_t weight) {
  return a + scale15(b - a, weight);
}

/// Bilinear; the texels around come from the face's border. RGBA in memory order, A = 255.
/// \pre p is of linear_scale()
inline std::uint32_t sample_colour(const Face& face, TexelPoint p) {
  const auto x = static_cast<std::int32_t>(p.x), y = static_cast<std::int32_t>(p.y);
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

/// The texel that holds the point. \pre p is of nearest_scale()
template <class T>
T sample_nearest(const Face& face, TexelPoint p) {
  const auto x = static_cast<std::size_t>(p.x), y = static_cast<std::size_t>(p.y);
  T value;
  std::memcpy(&value, face.origin + y * face.stride + x * sizeof(T), sizeof(T));
  return value;
}

/// IEEE half, rounded to nearest even.
inline std::uint16_t to_half(float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t sign = bits >> 16 & 0x8000U;
  const std::uint32_t magnitude = bits & 0x7FFFFFFFU;
  if (magnitude > 0x7F800000U) return static_cast<std::uint16_t>(sign | 0x7E00U);
  if (magnitude >= 0x47800000U) return static_cast<std::uint16_t>(sign | 0x7C00U);
  if (magnitude < 0x38800000U) {  // below the smallest normal half: units of 2^-24
    const float units = std::bit_cast<float>(magnitude) * 16777216.0F;
    return static_cast<std::uint16_t>(sign | static_cast<std::uint32_t>(std::nearbyint(units)));
  }
  const std::uint32_t even = magnitude >> 13 & 1U;
  return static_cast<std::uint16_t>(sign | ((magnitude - 0x38000000U + 0xFFFU + even) >> 13));
}

}  // namespace enfilade::render::cpu
