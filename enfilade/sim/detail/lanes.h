/// \file  Arithmetic without branches: a loop over it runs in vector registers, with every compiler
/// and for every instruction set.
#pragma once
#include <bit>
#include <cstdint>

namespace enfilade::sim::detail {

/// -1 where the condition holds, else 0: what select() chooses by.
constexpr std::int32_t mask(bool condition) noexcept { return -std::int32_t{condition}; }

/// `yes` where `mask` is -1, `no` where it is 0.
constexpr float select(std::int32_t mask, float yes, float no) noexcept {
  return std::bit_cast<float>((std::bit_cast<std::int32_t>(yes) & mask) |
                              (std::bit_cast<std::int32_t>(no) & ~mask));
}
constexpr double select(std::int64_t mask, double yes, double no) noexcept {
  return std::bit_cast<double>((std::bit_cast<std::int64_t>(yes) & mask) |
                               (std::bit_cast<std::int64_t>(no) & ~mask));
}

/// c0 + x (c1 + x (c2 + ...)), in this order of operations.
template <class T>
constexpr T polynomial(T, T c0) noexcept {
  return c0;
}
template <class T, class... Rest>
constexpr T polynomial(T x, T c0, Rest... rest) noexcept {
  return c0 + x * polynomial(x, rest...);
}

}  // namespace enfilade::sim::detail
