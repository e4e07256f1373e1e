/// \file  From light to what a screen shows: exposure's grey, the tone curve, sRGB.
#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>

namespace enfilade::image {

/// What a light meter takes the world for, and makes it: the share of light that an average scene
/// sends back.
template <std::floating_point T>
inline constexpr T kMidGrey = T(0.18);

/// Luminance of linear RGB with sRGB's primaries (ITU-R BT.709).
template <std::floating_point T>
constexpr T luminance(T r, T g, T b) {
  return T(0.2126) * r + T(0.7152) * g + T(0.0722) * b;
}

/// The tone curve: straight up to the knee at 0.4, then bent towards 1, which it never quite
/// reaches, so that bright windows keep their shapes. Value and slope are continuous; 0 below 0.
template <std::floating_point T>
T shoulder(T light) {
  constexpr T kKnee = T(0.4);
  if (light <= kKnee) return std::max(light, T(0));
  return kKnee + (1 - kKnee) * (1 - std::exp((kKnee - light) / (1 - kKnee)));
}

/// sRGB's curve (IEC 61966-2-1), from a byte / 255 to light. \pre value in [0, 1]
template <std::floating_point T>
T linear_from_srgb(T value) {
  return value <= T(0.04045) ? value / T(12.92) : std::pow((value + T(0.055)) / T(1.055), T(2.4));
}

/// Its inverse; light outside [0, 1] is cut off.
template <std::floating_point T>
T srgb_from_linear(T light) {
  light = std::clamp(light, T(0), T(1));
  return light <= T(0.0031308) ? light * T(12.92)
                               : T(1.055) * std::pow(light, 1 / T(2.4)) - T(0.055);
}

template <std::floating_point T>
std::uint8_t srgb8_from_linear(T light) {
  return static_cast<std::uint8_t>(std::lround(srgb_from_linear(light) * 255));
}

}  // namespace enfilade::image
