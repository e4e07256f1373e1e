/// \file  Numbers in IEEE half precision (binary16).
#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

namespace enfilade {

/// The bits of the nearest half, ties to even; infinity from 65520 on. NaN stays NaN.
inline std::uint16_t to_half(float value) noexcept {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  const std::uint32_t magnitude = bits & 0x7fffffffU;
  std::uint32_t half = 0;
  if (magnitude > 0x7f800000U) {  // not a number
    half = 0x7e00U;
  } else if (magnitude >= 0x477ff000U) {  // 65520
    half = 0x7c00U;
  } else if (magnitude < 0x38800000U) {
    // Below 2^-14 halves are multiples of 2^-24, which is what floats from 0.5 on are, too.
    half = std::bit_cast<std::uint32_t>(std::bit_cast<float>(magnitude) + 0.5F) - 0x3f000000U;
  } else {
    half = (magnitude - (112U << 23U) + 0xfffU + (magnitude >> 13U & 1U)) >> 13U;
  }
  return static_cast<std::uint16_t>(half | (bits >> 16U & 0x8000U));
}

/// Copies stored halves to floats. False if one of them is not finite.
/// \param from out.size() halves, aligned or not
bool copy_halves(const std::byte* from, std::span<float> out) noexcept;
/// The same for stored floats.
bool copy_floats(const std::byte* from, std::span<float> out) noexcept;

/// False if there is an infinity or NaN among them.
bool all_finite(std::span<const float> values) noexcept;

}  // namespace enfilade
