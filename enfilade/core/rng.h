/// \file  Random numbers: the same on every platform, for any batch size and number of threads.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace enfilade {

/// One stream of random numbers, named by a seed and up to two stream numbers (for example an agent
/// and its episode). Streams are independent, so results do not depend on batch size or threads.
/// SplitMix64 (Steele, Lea, Flood 2014) from a hashed start; passes BigCrush; not for cryptography.
/// The distributions of the standard library are not used, as they differ between implementations.
class Rng {
 public:
  /// Streams of one seed, and substreams of one stream, are independent of each other.
  explicit Rng(std::uint64_t seed, std::uint64_t stream = 0, std::uint64_t substream = 0) noexcept;

  /// Uniform over all 2^64 values.
  std::uint64_t next() noexcept;
  /// Uniform over 0 .. n-1, unbiased. \pre n > 0
  std::uint64_t below(std::uint64_t n) noexcept;
  /// Uniform over [0, 1): a multiple of 2^-53.
  double uniform() noexcept;

  /// All orders are equally likely (Fisher and Yates).
  template <class T>
  void shuffle(std::span<T> values) noexcept {
    for (std::size_t i = values.size(); i > 1; --i) std::swap(values[i - 1], values[below(i)]);
  }

 private:
  std::uint64_t state_;
};

/// A stream number for a name such as an instruction id: the same on every platform (FNV-1a).
std::uint64_t stream_of(const char* text, std::size_t size) noexcept;

}  // namespace enfilade
