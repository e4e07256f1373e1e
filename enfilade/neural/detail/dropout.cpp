#include "enfilade/neural/detail/dropout.h"

#include <ATen/ATen.h>
#include <ATen/CPUGeneratorImpl.h>

namespace enfilade::neural::detail {

Dropout::Dropout(std::uint64_t seed) : generator_(at::detail::createCPUGenerator(seed)) {}

at::Tensor Dropout::operator()(const at::Tensor& values, double rate) {
  if (rate <= 0) return values;
  const double kept = 1 - rate;
  // Drawn on the CPU, so that devices agree.
  const at::Tensor mask = at::empty(values.sizes(), at::kFloat).bernoulli_(kept, generator_);
  return values * mask.div_(kept).to(values.device());
}

}  // namespace enfilade::neural::detail
