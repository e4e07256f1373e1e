/// \file  atan2 in single precision with the bits of MatterSim's recordings, in vector registers.
///
/// C libraries differ in the last bit of atan2f(), between their own versions too; recorded
/// headings stay. So this is the function of the libraries of that time: e_atan2f.c and s_atanf.c,
/// Ian Lance Taylor's single-precision conversions of fdlibm, which carry this notice:
///
/// \code{.txt}
///   Copyright (C) 1993 by Sun Microsystems, Inc. All rights reserved.
///   Developed at SunPro, a Sun Microsystems, Inc. business.
///   Permission to use, copy, modify, and distribute this software is freely granted, provided
///   that this notice is preserved.
/// \endcode
///
/// Changed: it has no branches, so that a compiler can run a loop over it in vector registers. Its
/// branching twin is the oracle in atan2f_test.cpp.
#pragma once
#include <bit>
#include <cstdint>

namespace enfilade::sim::detail {

// Arithmetic without branches: a loop over it runs in vector registers, with every compiler and for
// every instruction set.

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

/// atan(ratio) for ratio >= 0, infinity included.
inline float atanf_fdlibm(float ratio) noexcept {
  // atan(ratio) = high + low + atan(t), |t| <= 7/16; bits of numbers >= 0 compare as they do.
  const auto bits = std::bit_cast<std::int32_t>(ratio);
  const std::int32_t over_7_16 = mask(bits >= 0x3ee00000);
  const std::int32_t over_11_16 = mask(bits >= 0x3f300000);
  const std::int32_t over_19_16 = mask(bits >= 0x3f980000);
  const std::int32_t over_39_16 = mask(bits >= 0x401c0000);
  const std::int32_t vast = mask(bits >= 0x4c000000);  // from 2^25 on, as good as infinite
  float numerator = select(over_7_16, 2.0F * ratio - 1.0F, ratio);
  float denominator = select(over_7_16, 2.0F + ratio, 1.0F);
  float high = select(over_7_16, 0x1.dac67p-2F, 0.0F);  // atan(1/2)
  float low = select(over_7_16, 0x1.586ed2p-28F, 0.0F);
  numerator = select(over_11_16, ratio - 1.0F, numerator);
  denominator = select(over_11_16, ratio + 1.0F, denominator);
  high = select(over_11_16, 0x1.921fb4p-1F, high);  // atan(1)
  low = select(over_11_16, 0x1.4442dp-25F, low);
  numerator = select(over_19_16, ratio - 1.5F, numerator);
  denominator = select(over_19_16, 1.0F + 1.5F * ratio, denominator);
  high = select(over_19_16, 0x1.f730bcp-1F, high);  // atan(3/2)
  low = select(over_19_16, 0x1.281f68p-25F, low);
  numerator = select(over_39_16, select(vast, 0.0F, -1.0F), numerator);
  denominator = select(over_39_16, ratio, denominator);
  high = select(over_39_16, 0x1.921fb4p0F, high);  // atan(infinity)
  low = select(over_39_16, 0x1.4442dp-24F, low);

  const float t = numerator / denominator;
  const float z = t * t;
  const float w = z * z;
  const float odd = z * polynomial(w, 0x1.555556p-2F, 0x1.24924ap-3F, 0x1.745cdcp-4F,
                                   0x1.10d66ap-4F, 0x1.97b4b2p-5F, 0x1.0ad3aep-6F);
  const float even = w * polynomial(w, -0x1.99999ap-3F, -0x1.c71c7p-4F, -0x1.3b0f2ap-4F,
                                    -0x1.dde2d6p-5F, -0x1.2b4442p-5F);
  return high - ((t * (odd + even) - low) - t);
}

/// atan2(y, x) in [-pi, pi] for finite numbers, zeros with signs included. The operations and their
/// order are fdlibm's: build with -ffp-contract=off.
inline float atan2f_fdlibm(float y, float x) noexcept {
  constexpr std::int32_t kMagnitude = 0x7fffffff;
  constexpr float kPi = 0x1.921fb6p1F;
  constexpr float kPiLow = -0x1.777a5cp-24F;  // pi = kPi + kPiLow
  const auto y_bits = std::bit_cast<std::int32_t>(y);
  const auto x_bits = std::bit_cast<std::int32_t>(x);
  const std::int32_t y_is_zero = mask((y_bits & kMagnitude) == 0);
  const std::int32_t x_is_zero = mask((x_bits & kMagnitude) == 0);
  const float quotient =
      std::bit_cast<float>(y_bits & kMagnitude) / std::bit_cast<float>(x_bits & kMagnitude);
  const float angle = atanf_fdlibm(select(y_is_zero, 0.0F, quotient));  // not 0 / 0

  // Into the quadrant of (x, y). On the y axis the sign of a zero x has no meaning, unless y is
  // zero.
  const std::int32_t behind = mask(x_bits < 0) & (y_is_zero | ~x_is_zero);
  const float turned = select(behind, kPi - (angle - kPiLow), angle);
  return std::bit_cast<float>(std::bit_cast<std::int32_t>(turned) ^ (y_bits & ~kMagnitude));
}

}  // namespace enfilade::sim::detail
