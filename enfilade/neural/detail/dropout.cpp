#include "enfilade/neural/detail/dropout.h"

#include <ATen/ATen.h>
#include <cmath>
#include <span>

namespace enfilade::neural::detail {
namespace {

// Four numbers of the mask from one random number of 64 bits, as drawing takes longer than all else
// here.
constexpr unsigned kBits = 16;
constexpr std::uint64_t kValues = 1U << kBits;

void fill_mask(Rng& rng, std::uint64_t dropped, float kept, std::span<float> out) {
  for (std::size_t i = 0; i < out.size();) {
    std::uint64_t bits = rng.next();
    for (unsigned k = 0; k < 64 / kBits && i < out.size(); ++k, bits >>= kBits) {
      out[i++] = bits % kValues >= dropped ? kept : 0;
    }
  }
}

}  // namespace

at::Tensor Dropout::operator()(const at::Tensor& values, double rate) {
  const auto dropped = static_cast<std::uint64_t>(std::lround(rate * double{kValues}));
  if (rate <= 0 || dropped == 0) return values;
  const double share = 1 - static_cast<double>(dropped) / double{kValues};
  // Drawn on the CPU, so that devices agree.
  const at::Tensor mask = at::empty(values.sizes(), at::kFloat);
  fill_mask(rng_, dropped, static_cast<float>(1 / share),
            {mask.data_ptr<float>(), static_cast<std::size_t>(mask.numel())});
  return values * mask.to(values.device());
}

}  // namespace enfilade::neural::detail
