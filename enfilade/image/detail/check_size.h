/// \file  Limits on the size of pictures that readers accept. Internal.
#pragma once
#include <fmt/format.h>
#include <cstdint>
#include <string>

#include "enfilade/core/errors.h"
#include "enfilade/image/codecs.h"

namespace enfilade::image::detail {

/// \throws InvalidInput for a size of 0, or above kLongestEdge or kMostPixels
inline void check_size(std::uint64_t width, std::uint64_t height, const std::string& file) {
  if (width > 0 && height > 0 && width <= kLongestEdge && height <= kLongestEdge &&
      width * height <= kMostPixels) {
    return;
  }
  refuse(file, "", "bad-size",
         fmt::format("{} x {} pixels; edges of 1 .. {} and at most {} pixels are allowed", width,
                     height, kLongestEdge, kMostPixels));
}

}  // namespace enfilade::image::detail
