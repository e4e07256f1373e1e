/// \file  The values of an enumeration by their names, as files and the command line have them.
#pragma once
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <array>
#include <cstddef>
#include <string_view>

#include "enfilade/core/errors.h"

namespace enfilade::models::detail {

/// Names of the values 0, 1, ... of T.
template <class T, std::size_t kCount>
struct NamedValues {
  std::string_view what;  ///< for messages
  std::array<std::string_view, kCount> names;

  std::string_view name(T value) const noexcept { return names[static_cast<std::size_t>(value)]; }
  /// \throws ArgumentError naming the names that there are
  T parse(std::string_view name) const {
    for (std::size_t i = 0; i < kCount; ++i) {
      if (names[i] == name) return static_cast<T>(i);
    }
    throw ArgumentError(
        fmt::format("{} {:?}: {} is allowed", what, name, fmt::join(names, " or ")));
  }
};

}  // namespace enfilade::models::detail
