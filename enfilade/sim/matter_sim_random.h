/// \file  The random starts of MatterSim, number for number, on any standard library.
#pragma once
#include <cstdint>

#include "enfilade/geometry/angle.h"

namespace enfilade::sim {

/// std::minstd_rand0 with libstdc++'s distributions on top, which the C++ standard leaves to each
/// library: x <- 16807 x mod 2^31 - 1. Poor numbers by today's measure; kept because recorded runs
/// start from them. A plain value: any thread.
class MatterSimRandom {
 public:
  /// A seed that is a multiple of 2^31 - 1 counts as 1. Negative ones were converted to 64 bits
  /// without sign.
  explicit MatterSimRandom(std::uint64_t seed = 1) noexcept;

  /// 1 .. 2^31 - 2.
  std::uint32_t next() noexcept;
  /// Uniform over 0 .. n-1: libstdc++'s uniform_int_distribution. \pre 0 < n <= 2^31 - 3
  std::uint32_t below(std::uint32_t n) noexcept;
  /// Uniform over [0, 1), from two draws: libstdc++'s generate_canonical<double, 53>.
  double uniform() noexcept;
  /// Uniform over [0, 2 pi).
  Radians heading() noexcept { return Radians(uniform() * (2 * kPi)); }

 private:
  std::uint32_t state_;
};

}  // namespace enfilade::sim
