#include "enfilade/models/panoramic_config.h"

#include <fmt/format.h>
#include <array>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::models {

constexpr std::array<std::string_view, 3> kSubouts{"tanh", "max", "own-max"};

std::string_view to_string(Subout value) noexcept {
  return kSubouts[static_cast<std::size_t>(value)];
}

Subout parse_subout(std::string_view name) {
  for (std::size_t i = 0; i < kSubouts.size(); ++i) {
    if (kSubouts[i] == name) return static_cast<Subout>(i);
  }
  throw ArgumentError(fmt::format("subout {:?}: tanh, max or own-max is allowed", name));
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
