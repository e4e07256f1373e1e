/// \file  Common sizes of EnvDrop's two networks.
#pragma once
#include <fmt/format.h>
#include <initializer_list>
#include <utility>

#include "enfilade/core/errors.h"

namespace enfilade::models::detail {

/// Checks `positive`, which are from 1 on, and what PanoramicConfig and SpeakerConfig both have.
/// \throws ArgumentError naming the first field that is out of range
template <class Config>
void validate_sizes(const Config& config,
                    std::initializer_list<std::pair<const char*, std::size_t>> positive) {
  constexpr double kMostSize = 1U << 24U;
  constexpr double kMostDropout = 0.99;
  for (const auto& [name, size] : positive) {
    check_range(name, static_cast<double>(size), 1, kMostSize);
  }
  check_range("image", static_cast<double>(config.image), 0, kMostSize);
  if (config.bidirectional && config.hidden % 2 != 0) {
    throw ArgumentError(fmt::format("hidden: {}, not even, as two directions need", config.hidden));
  }
  if (config.angle % 4 != 0) {
    throw ArgumentError(fmt::format("angle: {}, not a multiple of 4", config.angle));
  }
  check_range("dropout", config.dropout, 0, kMostDropout);
  check_range("feature_dropout", config.feature_dropout, 0, kMostDropout);
}

}  // namespace enfilade::models::detail
