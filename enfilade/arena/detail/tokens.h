/// \file  Counts of tokens, which a server or a file says.
#pragma once
#include <algorithm>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "enfilade/arena/detail/limits.h"

namespace enfilade::arena::detail {

/// A count of an object that may be anybody's: at most kMostTokens; 0 for what is no count.
inline std::int64_t tokens_in(const nlohmann::ordered_json& object, const char* name) {
  const auto count = object.find(name);
  if (count == object.end() || !count->is_number_unsigned()) return 0;
  return static_cast<std::int64_t>(std::min(count->get<std::uint64_t>(), kMostTokens));
}

}  // namespace enfilade::arena::detail
