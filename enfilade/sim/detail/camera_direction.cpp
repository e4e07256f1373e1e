#include "enfilade/sim/detail/camera_direction.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "enfilade/sim/detail/lanes.h"

namespace enfilade::sim::detail {
namespace {

constexpr std::size_t kLanes = 8;  // loops run over whole blocks, so that compilers unroll them

// compute_sincos() is off by less than 4e-16 (three roundings of numbers up to 1, and the terms
// that the series leaves out), the C library by less than 2e-16. This is twice their sum: if value
// - kMargin and value + kMargin round to the same float, direction_of() rounds to it too.
constexpr double kMargin = 1.2e-15;

double with_sign_of_bit_1(double value, std::int64_t bits) {
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(value) ^
                               ((static_cast<std::uint64_t>(bits) & 2U) << 62U));
}

struct SinCos {
  double sin, cos;
};

// For |angle| <= 2 pi. No branches: a loop over it runs in vector registers.
SinCos compute_sincos(double angle) {
  // The nearest multiple of pi/2 is taken off, in two parts of which the first has so few digits
  // that its multiples are exact. Adding 1.5 * 2^52 rounds, and leaves the multiple's last bits.
  constexpr double kRounder = 0x1.8p52;
  constexpr double kHalfPiHigh = 0x1.921fb544p0;
  constexpr double kHalfPiLow = 0x1.0b4611a626331p-34;
  const double rounded = angle * (2 / kPi) + kRounder;
  const auto quadrant = std::bit_cast<std::int64_t>(rounded);
  const double multiple = rounded - kRounder;
  const double r = (angle - multiple * kHalfPiHigh) - multiple * kHalfPiLow;

  // Taylor's series; |r| <= pi/4, so that the first term left out is below 5e-17.
  const double z = r * r;
  const double sin_r = r + r * z *
                               polynomial(z, -1.0 / 6, 1.0 / 120, -1.0 / 5040, 1.0 / 362880,
                                          -1.0 / 39916800, 1.0 / 6227020800, -1.0 / 1307674368000);
  const double cos_r =
      1 + z * polynomial(z, -1.0 / 2, 1.0 / 24, -1.0 / 720, 1.0 / 40320, -1.0 / 3628800,
                         1.0 / 479001600, -1.0 / 87178291200, 1.0 / 20922789888000);
  const std::int64_t odd = -(quadrant & 1);
  return {with_sign_of_bit_1(select(odd, cos_r, sin_r), quadrant),
          with_sign_of_bit_1(select(odd, sin_r, cos_r), quadrant + 1)};
}

// 0 if the rounded value is sure.
std::uint32_t doubt(double value) {
  return std::bit_cast<std::uint32_t>(static_cast<float>(value - kMargin)) ^
         std::bit_cast<std::uint32_t>(static_cast<float>(value + kMargin));
}

}  // namespace

Direction direction_of(Radians heading) {
  const double angle = kPi / 2 - heading.value;
  return {static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
}

void compute_directions(std::span<const double> headings, std::span<Direction> out) {
  for (std::size_t begin = 0; begin < headings.size(); begin += kLanes) {
    const std::size_t n = std::min(kLanes, headings.size() - begin);
    std::array<double, kLanes> angle{};
    std::array<float, kLanes> x, y;
    std::array<std::uint32_t, kLanes> doubts;
    for (std::size_t i = 0; i < n; ++i) angle[i] = kPi / 2 - headings[begin + i];
    for (std::size_t i = 0; i < kLanes; ++i) {
      const SinCos value = compute_sincos(angle[i]);
      x[i] = static_cast<float>(value.cos);
      y[i] = static_cast<float>(value.sin);
      doubts[i] = doubt(value.cos) | doubt(value.sin);
    }
    for (std::size_t i = 0; i < n; ++i) {
      out[begin + i] =
          doubts[i] == 0 ? Direction{x[i], y[i]} : direction_of(Radians(headings[begin + i]));
    }
  }
}

}  // namespace enfilade::sim::detail
