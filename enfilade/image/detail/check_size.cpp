#include "enfilade/image/detail/check_size.h"

#include <fmt/format.h>

#include "enfilade/core/errors.h"
#include "enfilade/image/codecs.h"

namespace enfilade::image::detail {

void check_size(std::uint64_t width, std::uint64_t height, const std::string& file) {
  if (width == 0 || height == 0 || width > kLongestEdge || height > kLongestEdge ||
      width * height > kMostPixels) {
    refuse(file, "", "bad-size",
           fmt::format("{} x {} pixels; edges of 1 .. {} and at most {} pixels are allowed", width,
                       height, kLongestEdge, kMostPixels));
  }
}

}  // namespace enfilade::image::detail
