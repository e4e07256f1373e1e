/// \file  What the JSON of requests may hold. One rule for all of them: what a route reads is
/// bounded in bytes, levels and values before it is parsed, so that the memory that it takes is.
#pragma once
#include <string_view>

#include "enfilade/core/detail/json.h"

namespace enfilade::service::detail {

/// No request has more than seven levels.
inline constexpr std::size_t kMostLevels = 16;
/// Names, texts, choices: of routes that take up to 16 KiB.
inline constexpr json::Limits kFormLimits{1000, kMostLevels};
/// A worker's draft or walk: 5000 steps of four numbers and their names.
inline constexpr json::Limits kWorkLimits{60'000, kMostLevels};
/// A new collection: 100,000 paths with three instructions each, 23 values and keys a path.
inline constexpr json::Limits kCollectionLimits{2'500'000, kMostLevels};

/// \throws InvalidInput "too-large" for a text beyond the limits  \param file its name in messages
inline void check_limits(std::string_view text, const char* file, const json::Limits& limits) {
  const std::string found = json::excess(text, limits);
  if (!found.empty()) refuse(file, "$", "too-large", found);
}

}  // namespace enfilade::service::detail
