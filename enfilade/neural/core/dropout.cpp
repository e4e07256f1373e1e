#include "enfilade/neural/core/dropout.h"

#include <ATen/ATen.h>
#include <ATen/Context.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>
#include <tuple>

#include "enfilade/core/check.h"
#include "enfilade/neural/core/simd_kernels.h"

namespace enfilade::neural::core {
namespace {

// Four numbers of the mask from one random number of 64 bits, as drawing takes longer than all else
// here.
constexpr unsigned kBits = 16;
constexpr std::uint64_t kValues = 1U << kBits;

void fill_mask(Rng& rng, std::uint64_t dropped, float kept, std::span<float> out) {
  constexpr std::size_t kBlock = 256;
  std::array<std::uint16_t, kBlock * 64 / kBits> bits;
  for (std::size_t i = 0; i < out.size(); i += bits.size()) {
    const std::size_t n = std::min(bits.size(), out.size() - i);
    for (std::size_t k = 0; k * 64 / kBits < n; ++k) {
      const std::uint64_t drawn = rng.next();
      for (std::size_t part = 0; part < 64 / kBits; ++part) {
        bits[k * 64 / kBits + part] = static_cast<std::uint16_t>(drawn >> (part * kBits));
      }
    }
    simd_kernels().keep(bits.data(), static_cast<std::uint32_t>(dropped), kept, out.data() + i, n);
  }
}

}  // namespace

Dropout::Dropout(std::uint64_t seed, c10::Device device) : rng_(seed), device_(device) {
  if (device.is_cpu()) return;
  at::Generator generator = at::globalContext().defaultGenerator(device);
  generator.set_current_seed(seed);
}

at::Tensor Dropout::mask(at::IntArrayRef sizes, double rate) {
  const auto dropped = static_cast<std::uint64_t>(std::lround(rate * double{kValues}));
  if (rate <= 0 || dropped == 0) return {};
  const double share = 1 - static_cast<double>(dropped) / double{kValues};
  EN_CHECK(device_.is_cpu());
  at::Tensor mask = at::empty(sizes, at::kFloat);
  fill_mask(rng_, dropped, static_cast<float>(1 / share),
            {mask.data_ptr<float>(), static_cast<std::size_t>(mask.numel())});
  return mask;
}

at::Tensor Dropout::operator()(const at::Tensor& values, double rate) {
  if (!device_.is_cpu()) {
    return rate > 0 ? std::get<0>(at::native_dropout(values, rate, true)) : values;
  }
  const at::Tensor factors = mask(values.sizes(), rate);
  return factors.defined() ? values * factors : values;
}

}  // namespace enfilade::neural::core
