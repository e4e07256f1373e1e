/// \file  Limits of messages of the Model Context Protocol.
#pragma once
#include "enfilade/core/detail/json.h"

namespace enfilade::arena::detail {

// Messages are copied recursively, and a repeated name is searched for one by one.
inline constexpr json::Limits kMessageLimits{.values = 10'000, .depth = 64};

}  // namespace enfilade::arena::detail
