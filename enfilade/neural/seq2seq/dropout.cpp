#include "enfilade/neural/seq2seq/dropout.h"

#include "enfilade/core/rng.h"

namespace enfilade::neural::seq2seq {
namespace {

// Steps are far below 2^24.
std::uint64_t substream(Site site, MaskRow at) noexcept {
  return (std::uint64_t{static_cast<std::uint8_t>(site)} << 56U) | (std::uint64_t{at.step} << 32U) |
         at.row;
}

}  // namespace

void draw_mask(const Dropout& dropout, Site site, MaskRow at, std::size_t width,
               std::span<std::uint64_t> out) noexcept {
  Rng rng(dropout.seed, dropout.stream, substream(site, at));
  const std::size_t words = mask_words(width);
  if (dropout.probability == 0.5) {
    for (std::size_t w = 0; w < words; ++w) out[w] = rng.next();
    return;
  }
  const auto dropped = static_cast<std::uint64_t>(dropout.probability * 0x1p32);
  for (std::size_t w = 0; w < words; ++w) {
    std::uint64_t bits = 0;
    for (unsigned i = 0; i < 64; i += 2) {
      const std::uint64_t two = rng.next();
      bits |= std::uint64_t{(two & 0xffffffffU) >= dropped} << i;
      bits |= std::uint64_t{(two >> 32U) >= dropped} << (i + 1);
    }
    out[w] = bits;
  }
}

double draw_uniform(std::uint64_t seed, std::uint64_t stream, MaskRow at) noexcept {
  return Rng(seed, stream, substream(Site::kDraw, at)).uniform();
}

}  // namespace enfilade::neural::seq2seq
