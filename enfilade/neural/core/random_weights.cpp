#include "enfilade/neural/core/random_weights.h"

#include <ATen/ATen.h>
#include <cmath>
#include <numbers>
#include <span>

namespace enfilade::neural::core {

at::Tensor normal(const std::vector<std::int64_t>& shape, double deviation, Rng& rng) {
  at::Tensor tensor = at::empty(shape, at::kFloat);
  const std::span<float> numbers(tensor.data_ptr<float>(),
                                 static_cast<std::size_t>(tensor.numel()));
  for (std::size_t i = 0; i < numbers.size(); i += 2) {  // Box and Muller: two at a time
    const double radius = deviation * std::sqrt(-2 * std::log1p(-rng.uniform()));
    const double angle = 2 * std::numbers::pi * rng.uniform();
    numbers[i] = static_cast<float>(radius * std::cos(angle));
    if (i + 1 < numbers.size()) numbers[i + 1] = static_cast<float>(radius * std::sin(angle));
  }
  return tensor;
}

at::Tensor he_normal(const std::vector<std::int64_t>& shape, Rng& rng) {
  std::int64_t inputs = 1;
  for (std::size_t i = 1; i < shape.size(); ++i) inputs *= shape[i];
  return normal(shape, std::sqrt(2.0 / static_cast<double>(inputs)), rng);
}

}  // namespace enfilade::neural::core
