/// \file  IEEE half precision, which features are often kept in.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace enfilade::features::detail {

/// Nearest, ties to even; infinity from 65520 on.
std::uint16_t to_half(float value) noexcept;

// What is stored, as floats. False if a number among them is not finite. `from` has out.size()
// elements and need not be aligned.
bool copy_halves(const std::byte* from, std::span<float> out) noexcept;
bool copy_floats(const std::byte* from, std::span<float> out) noexcept;

bool all_finite(std::span<const float> values) noexcept;

}  // namespace enfilade::features::detail
