/// \file  Dropout with masks from a counter-based generator, so masks need not be stored.
#pragma once
#include <cstddef>
#include <cstdint>
#include <span>

namespace enfilade::neural::seq2seq {

/// Places in the network that use random numbers.
enum class Site : std::uint8_t { kWords, kContext, kActions, kFeatures, kAttention, kDraw };

/// A row of a batch at a word or step.
struct MaskRow {
  std::uint32_t step = 0;
  std::uint32_t row = 0;
};

/// Dropout of one rollout. A mask is a function of these numbers, its site, step and row. So the
/// backward pass computes it again, on any number of threads and any device.
struct Dropout {
  std::uint64_t seed = 1;
  std::uint64_t stream = 0;
  double probability = 0;  ///< [0, 1); 0: nothing is dropped, nothing drawn

  bool on() const noexcept { return probability > 0; }
  float scale() const noexcept { return static_cast<float>(1 / (1 - probability)); }
};

constexpr std::size_t mask_words(std::size_t width) noexcept { return (width + 63) / 64; }

/// Bit i of the mask (bit i % 64 of word i / 64): 1 if element i is kept. One random bit per
/// element is used if the probability is 1/2, else 32.
/// \pre out.size() >= mask_words(width)
void draw_mask(const Dropout& dropout, Site site, MaskRow at, std::size_t width,
               std::span<std::uint64_t> out) noexcept;

/// Uniform in [0, 1), for sampling the action of a row at a step.
double draw_uniform(std::uint64_t seed, std::uint64_t stream, MaskRow at) noexcept;

}  // namespace enfilade::neural::seq2seq
