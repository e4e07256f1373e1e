/// \file  A JPEG with the same coefficients in baseline coding. Internal.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "enfilade/image/codecs.h"

namespace enfilade::image::detail {

/// With the standard's tables, one scan, no restart markers, no comments. \throws InvalidInput
std::vector<std::uint8_t> to_baseline(Bytes jpeg, const std::string& file);

}  // namespace enfilade::image::detail
