#include "enfilade/neural/speaker/environmental_dropout.h"

#include <fmt/format.h>
#include <map>
#include <memory>
#include <utility>

#include "enfilade/core/errors.h"
#include "enfilade/core/rng.h"

namespace enfilade::neural::speaker {
namespace {

void check_rate(double rate) {
  if (rate >= 0 && rate < 1) return;
  throw ArgumentError(fmt::format("environmental dropout: {}, not in [0, 1)", rate));
}

}  // namespace

std::vector<float> column_factors(const EnvironmentalDropoutOptions& options, std::size_t columns,
                                  ScanIndex scan) {
  check_rate(options.rate);
  const bool own = options.same == SameEnvironment::kScan;
  Rng rng(options.seed, options.stream, own ? scan.at() + 1 : 0);
  const auto kept = static_cast<float>(1 / (1 - options.rate));
  std::vector<float> factors(columns);
  for (float& factor : factors) factor = rng.uniform() < options.rate ? 0.0F : kept;
  return factors;
}

ImageSource drop_environment(ImageSource images, const EnvironmentalDropoutOptions& options) {
  check_rate(options.rate);
  // Shared by copies of the function, which all have the same factors.
  const auto known = std::make_shared<std::map<ScanIndex, std::vector<float>>>();
  return [images = std::move(images), options, known](graph::Location at, std::uint32_t view,
                                                      std::span<float> out) {
    images(at, view, out);
    const ScanIndex key = options.same == SameEnvironment::kScan ? at.scan : ScanIndex(0);
    std::vector<float>& factors = (*known)[key];
    if (factors.size() != out.size()) factors = column_factors(options, out.size(), at.scan);
    for (std::size_t c = 0; c < out.size(); ++c) out[c] *= factors[c];
  };
}

}  // namespace enfilade::neural::speaker
