#include "enfilade/core/half.h"

#include <array>
#include <cstring>

namespace enfilade {
namespace {

// Loops of this length have no remainder, so compilers turn them into vector instructions.
constexpr std::size_t kBlock = 16;

// Avoids denormal floats, which a thread may be set to treat as zero, and chooses between integers,
// as gcc 12 compiles a choice between floats to a branch.
inline float to_float(std::uint32_t half) {
  const std::uint32_t magnitude = (half & 0x7fffU) << 13U;
  const std::uint32_t normal = magnitude + (112U << 23U);
  const auto subnormal =
      std::bit_cast<std::uint32_t>(std::bit_cast<float>(magnitude + (113U << 23U)) - 0x1p-14F);
  const std::uint32_t is_subnormal =
      0U - static_cast<std::uint32_t>((magnitude & 0x0f800000U) == 0);
  const std::uint32_t value = (normal & ~is_subnormal) | (subnormal & is_subnormal);
  return std::bit_cast<float>(value | (half & 0x8000U) << 16U);
}

inline std::uint32_t infinite_or_nan(std::uint16_t half) {
  return static_cast<std::uint32_t>((half & 0x7c00U) == 0x7c00U);
}

inline std::uint32_t infinite_or_nan(float value) {
  constexpr std::uint32_t kExponent = 0x7f800000U;
  return static_cast<std::uint32_t>((std::bit_cast<std::uint32_t>(value) & kExponent) == kExponent);
}

}  // namespace

bool copy_halves(const std::byte* from, std::span<float> out) noexcept {
  std::uint32_t wrong = 0;
  std::size_t i = 0;
  std::array<std::uint16_t, kBlock> halves;
  for (; i + kBlock <= out.size(); i += kBlock) {
    std::memcpy(halves.data(), from + 2 * i, sizeof(halves));
    float* to = out.data() + i;
    for (std::size_t k = 0; k < kBlock; ++k) wrong |= infinite_or_nan(halves[k]);
    for (std::size_t k = 0; k < kBlock; ++k) to[k] = to_float(halves[k]);
  }
  for (; i < out.size(); ++i) {
    std::memcpy(halves.data(), from + 2 * i, sizeof(std::uint16_t));
    wrong |= infinite_or_nan(halves[0]);
    out[i] = to_float(halves[0]);
  }
  return wrong == 0;
}

bool copy_floats(const std::byte* from, std::span<float> out) noexcept {
  if (!out.empty()) std::memcpy(out.data(), from, out.size_bytes());
  return all_finite(out);
}

bool all_finite(std::span<const float> values) noexcept {
  std::uint32_t wrong = 0;
  std::size_t i = 0;
  for (; i + kBlock <= values.size(); i += kBlock) {
    const float* block = values.data() + i;
    for (std::size_t k = 0; k < kBlock; ++k) wrong |= infinite_or_nan(block[k]);
  }
  for (; i < values.size(); ++i) wrong |= infinite_or_nan(values[i]);
  return wrong == 0;
}

}  // namespace enfilade
