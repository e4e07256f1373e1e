/// \file  sRGB's curve (IEC 61966-2-1). Internal.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstdint>

namespace enfilade::mesh {

/// \param value in [0, 1]
inline float linear_from_srgb(float value) {
  return value <= 0.04045F ? value / 12.92F : std::pow((value + 0.055F) / 1.055F, 2.4F);
}
inline float srgb_from_linear(float value) {
  value = std::clamp(value, 0.0F, 1.0F);
  return value <= 0.0031308F ? value * 12.92F : 1.055F * std::pow(value, 1 / 2.4F) - 0.055F;
}
inline std::uint8_t srgb8_from_linear(float value) {
  return static_cast<std::uint8_t>(std::lround(srgb_from_linear(value) * 255));
}

}  // namespace enfilade::mesh
