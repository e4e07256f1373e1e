#include "enfilade/models/speaker_config.h"

#include <fmt/format.h>
#include <array>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::models {

void validate(const SpeakerConfig& config) {
  constexpr double kMostSize = 1U << 24U;
  const std::array<std::pair<const char*, std::size_t>, 4> sizes{
      {{"vocabulary", config.vocabulary},
       {"word_embedding", config.word_embedding},
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
