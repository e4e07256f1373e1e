#include "enfilade/models/panoramic_config.h"

#include <fmt/format.h>
#include <array>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::models {

std::string_view to_string(Subout value) noexcept {
  return value == Subout::kTanh ? "tanh" : "max";
}

Subout parse_subout(std::string_view name) {
  if (name == to_string(Subout::kTanh)) return Subout::kTanh;
  if (name == to_string(Subout::kMax)) return Subout::kMax;
  throw ArgumentError(fmt::format("subout {:?}: tanh or max is allowed", name));
}

void validate(const PanoramicConfig& config) {
  constexpr double kMostSize = 1U << 24U;
  const std::array<std::pair<const char*, std::size_t>, 5> sizes{
      {{"vocabulary", config.vocabulary},
       {"word_embedding", config.word_embedding},
       {"action_embedding", config.action_embedding},
       {"hidden", config.hidden},
       {"angle", config.angle}}};
  for (const auto& [name, size] : sizes) {
    check_range(name, static_cast<double>(size), 1, kMostSize);
  }
  check_range("image", static_cast<double>(config.image), 0, kMostSize);
  if (config.bidirectional && config.hidden % 2 != 0) {
    throw ArgumentError(fmt::format("hidden: {}, not even, as two directions need", config.hidden));
  }
  if (config.angle % 4 != 0) {
    throw ArgumentError(fmt::format("angle: {}, not a multiple of 4", config.angle));
  }
  constexpr double kMostDropout = 0.99;
  check_range("dropout", config.dropout, 0, kMostDropout);
  check_range("feature_dropout", config.feature_dropout, 0, kMostDropout);
}

}  // namespace enfilade::models
