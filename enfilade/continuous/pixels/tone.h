/// \file  From linear light to bytes and back, by tables.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "enfilade/geometry/vec.h"

namespace enfilade::continuous::pixels {

/// Texels are filtered as sRGB in 1 / 256 of a byte's step; this has the linear values of quarter
/// steps.
class LinearTable {
 public:
  LinearTable();
  /// \param value in 1 / 256 of a byte's step, at most 255 * 256
  float of(std::uint32_t value) const { return values_[value >> 6U]; }
  const float* table() const { return values_.data(); }

 private:
  std::array<float, 1024> values_;
};

/// sRGB bytes of linear light, with or without the tone curve of pictures of lit meshes. A value is
/// looked up by its exponent and the first eight bits of its fraction, which is finer than a byte's
/// step.
class ToneTable {
 public:
  /// With image::shoulder(), or plain sRGB.
  enum class Curve : std::uint8_t { kShoulder, kPlain };
  explicit ToneTable(Curve curve);

  std::uint8_t of(float light) const {
    if (!(light >= kLeast)) return 0;
    const auto bits = std::bit_cast<std::uint32_t>(std::min(light, kMost));
    return static_cast<std::uint8_t>(bytes_[(bits - kLeastBits) >> kDropped]);
  }
  /// RGBA, R lowest, A = 255.
  std::uint32_t rgba(Vec3f light) const {
    return std::uint32_t{of(light.x)} | std::uint32_t{of(light.y)} << 8U |
           std::uint32_t{of(light.z)} << 16U | 255U << 24U;
  }

  const std::uint32_t* table() const { return bytes_.data(); }
  static constexpr std::uint32_t kDropped = 15;
  static constexpr float kLeast = 1.0F / (1U << 14U);  // below: sRGB's byte 0
  static constexpr float kMost = 31.9F;                // above: byte 255 with either curve
  static constexpr auto kLeastBits = std::bit_cast<std::uint32_t>(kLeast);
  static constexpr auto kMostBits = std::bit_cast<std::uint32_t>(kMost);

 private:
  // As 32 bits each, which is what vector instructions gather.
  std::array<std::uint32_t, ((kMostBits - kLeastBits) >> kDropped) + 1> bytes_;
};

/// Colours of light in 32 bits: a common exponent and nine bits each (as OpenGL's RGB9_E5). The
/// error is at most 1 / 512 of the largest part. \pre parts are not negative
std::uint32_t pack_light(Vec3f light);
inline Vec3f unpack_light(std::uint32_t packed) {
  // 2^(exponent - 15 - 9) as a float's bits.
  const float scale = std::bit_cast<float>(((packed >> 27U) + (127 - 24)) << 23U);
  return {scale * static_cast<float>(packed & 511U),
          scale * static_cast<float>(packed >> 9U & 511U),
          scale * static_cast<float>(packed >> 18U & 511U)};
}

}  // namespace enfilade::continuous::pixels
