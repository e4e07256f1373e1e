/// \file  Names of the kinds of goals in the API.
#pragma once
#include <array>
#include <variant>

#include "enfilade/tasks/goal.h"

namespace enfilade::service::detail {

/// "end", "hidden", "turning_point", "object", "region" or "boxes". Any thread.
inline const char* name_of_kind(const tasks::Goal& goal) {
  constexpr std::array<const char*, std::variant_size_v<tasks::Goal>> kNames{
      "end", "hidden", "turning_point", "object", "region", "boxes"};
  return kNames.at(goal.index());
}

}  // namespace enfilade::service::detail
