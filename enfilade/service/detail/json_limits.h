/// \file  Limits of the JSON of requests. One rule for all: a body is bounded in bytes, levels and
/// values before it is parsed, and so is the memory that it takes.
#pragma once
#include <string_view>

#include "enfilade/core/detail/json.h"

namespace enfilade::service::detail {

/// No request has more than seven levels.
inline constexpr std::size_t kMostLevels = 16;
/// Names, texts, choices: of routes that take up to 16 KiB.
inline constexpr json::Limits kFormLimits{1000, kMostLevels};
/// A worker's draft or trajectory: 5000 steps of four numbers and their names.
inline constexpr json::Limits kWorkLimits{60'000, kMostLevels};
/// A new collection: 100,000 paths with three instructions each, 23 values and keys per path.
inline constexpr json::Limits kCollectionLimits{2'500'000, kMostLevels};

/// \throws InvalidInput "too-large" for a text beyond the limits  \param file its name in messages
inline void check_limits(std::string_view text, const char* file, const json::Limits& limits) {
  const std::string found = json::excess(text, limits);
  if (!found.empty()) refuse(file, "$", "too-large", found);
}

}  // namespace enfilade::service::detail
