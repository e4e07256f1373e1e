#include "enfilade/core/rng.h"

namespace enfilade {
namespace {

constexpr std::uint64_t kGolden = 0x9e3779b97f4a7c15U;  // 2^64 / golden ratio, SplitMix64's step

std::uint64_t mix(std::uint64_t z) noexcept {
  z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9U;
  z = (z ^ (z >> 27U)) * 0x94d049bb133111ebU;
  return z ^ (z >> 31U);
}

}  // namespace

Rng::Rng(std::uint64_t seed, std::uint64_t stream, std::uint64_t substream) noexcept
    : state_(mix(mix(mix(seed + kGolden) ^ (stream + kGolden)) ^ (substream + 2 * kGolden))) {}

std::uint64_t Rng::next() noexcept {
  state_ += kGolden;
  return mix(state_);
}

std::uint64_t Rng::below(std::uint64_t n) noexcept {
  // Values past the last whole multiple of n would favour small results: draw again.
  const std::uint64_t past = ~std::uint64_t{0} - (~std::uint64_t{0} % n + 1) % n;
  std::uint64_t x = next();
  while (x > past) x = next();
  return x % n;
}

double Rng::uniform() noexcept { return static_cast<double>(next() >> 11U) * 0x1p-53; }

std::uint64_t stream_of(const char* text, std::size_t size) noexcept {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (std::size_t i = 0; i < size; ++i) {
    hash = (hash ^ static_cast<unsigned char>(text[i])) * 0x100000001b3U;
  }
  return hash;
}

}  // namespace enfilade
