/// \file  Names out of files that become names of files.
#pragma once
#include <fmt/format.h>
#include <string>

#include "enfilade/core/errors.h"

namespace enfilade::exports::detail {

/// The name itself.
/// \throws ArgumentError for a name that could lead out of its folder: with a slash, a backslash or
/// a quotation mark, or a full stop first
inline const std::string& checked_file_name(const std::string& name) {
  if (name.find_first_of("/\\\"") != std::string::npos || name.starts_with('.')) {
    throw ArgumentError(fmt::format("{:?}: not a name of a file", name.substr(0, 80)));
  }
  return name;
}

}  // namespace enfilade::exports::detail
