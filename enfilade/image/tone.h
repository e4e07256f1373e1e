/// \file  Linear light to display colours: exposure, tone curve, sRGB.
#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>

namespace enfilade::image {

/// Mid-grey: the mean reflectance of a scene that exposure is set for.
template <std::floating_point T>
inline constexpr T kMidGrey = T(0.18);

/// Luminance of linear RGB with sRGB's primaries (ITU-R BT.709).
template <std::floating_point T>
constexpr T luminance(T r, T g, T b) {
  return T(0.2126) * r + T(0.7152) * g + T(0.0722) * b;
}

/// The tone curve: linear up to 0.4, then approaching 1 asymptotically, so that bright windows keep
/// their structure. Value and slope are continuous; 0 for negative light.
template <std::floating_point T>
T shoulder(T light) {
  constexpr T kKnee = T(0.4);
  if (light <= kKnee) return std::max(light, T(0));
  return kKnee + (1 - kKnee) * (1 - std::exp((kKnee - light) / (1 - kKnee)));
}

/// sRGB (IEC 61966-2-1) to linear light, for a byte / 255. \pre value in [0, 1]
template <std::floating_point T>
T linear_from_srgb(T value) {
  return value <= T(0.04045) ? value / T(12.92) : std::pow((value + T(0.055)) / T(1.055), T(2.4));
}

/// Its inverse; light outside [0, 1] is clamped.
template <std::floating_point T>
T srgb_from_linear(T light) {
  light = std::clamp(light, T(0), T(1));
  return light <= T(0.0031308) ? light * T(12.92)
                               : T(1.055) * std::pow(light, 1 / T(2.4)) - T(0.055);
}

/// As srgb_from_linear(), rounded to 0 .. 255.
template <std::floating_point T>
std::uint8_t srgb8_from_linear(T light) {
  return static_cast<std::uint8_t>(std::lround(srgb_from_linear(light) * 255));
}

/// linear_from_srgb() of each byte.
inline const std::array<float, 256>& linear_bytes() {
  static const std::array<float, 256> kTable = [] {
    std::array<float, 256> table{};
    for (std::size_t i = 0; i < table.size(); ++i) {
      table[i] = linear_from_srgb(static_cast<float>(i) / 255);
    }
    return table;
  }();
  return kTable;
}

/// srgb8_from_linear() from a table, without a power: exact to a rounding at byte borders.
inline std::uint8_t srgb_byte(float light) {
  constexpr std::size_t kSteps = 1U << 14U;
  static const std::array<std::uint8_t, kSteps + 1> kTable = [] {
    std::array<std::uint8_t, kSteps + 1> table{};
    for (std::size_t i = 0; i <= kSteps; ++i) {
      table[i] = srgb8_from_linear(static_cast<float>(i) / kSteps);
    }
    return table;
  }();
  return kTable[static_cast<std::size_t>(std::clamp(light, 0.0F, 1.0F) * kSteps + 0.5F)];
}

}  // namespace enfilade::image
