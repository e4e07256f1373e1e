/// \file  Limits on the size of pictures that readers accept.
#pragma once
#include <cstdint>
#include <string>

namespace enfilade::image::detail {

/// \throws InvalidInput for a size of 0, or above kLongestEdge or kMostPixels
void check_size(std::uint64_t width, std::uint64_t height, const std::string& file);

}  // namespace enfilade::image::detail
