#include "enfilade/sim/matter_sim_random.h"

#include <cmath>

namespace enfilade::sim {
namespace {

constexpr std::uint64_t kMultiplier = 16807;
constexpr std::uint64_t kModulus = 2147483647;  // 2^31 - 1, prime
constexpr std::uint32_t kMin = 1;
constexpr std::uint32_t kMax = kModulus - 1;

}  // namespace

MatterSimRandom::MatterSimRandom(std::uint64_t seed) noexcept
    : state_(static_cast<std::uint32_t>(seed % kModulus == 0 ? 1 : seed % kModulus)) {}

std::uint32_t MatterSimRandom::next() noexcept {
  state_ = static_cast<std::uint32_t>(state_ * kMultiplier % kModulus);
  return state_;
}

std::uint32_t MatterSimRandom::below(std::uint32_t n) noexcept {
  const std::uint32_t scaling = (kMax - kMin) / n;
  const std::uint32_t past = n * scaling;
  std::uint32_t drawn = next() - kMin;
  while (drawn >= past) drawn = next() - kMin;
  return drawn / scaling;
}

double MatterSimRandom::uniform() noexcept {
  constexpr double kRange = static_cast<double>(kMax - kMin) + 1;
  const double low = next() - kMin;
  const double high = next() - kMin;
  const double value = (low + high * kRange) / (kRange * kRange);
  return value < 1 ? value : std::nextafter(1.0, 0.0);
}

}  // namespace enfilade::sim
