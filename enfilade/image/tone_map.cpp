#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "enfilade/core/threads.h"
#include "enfilade/image/codecs.h"
#include "enfilade/image/tone.h"

namespace enfilade::image {
namespace {

// The factor by which the median becomes mid-grey. Black pixels are left out (a studio's panorama
// may be mostly black).
double metered_scale(const ImageF& linear) {
  std::vector<float> values;
  values.reserve(linear.pixels.size() / 3);
  for (std::size_t i = 0; i < linear.pixels.size(); i += 3) {
    const float* rgb = linear.pixels.data() + i;
    const auto value = static_cast<float>(luminance<double>(rgb[0], rgb[1], rgb[2]));
    if (value > 0 && std::isfinite(value)) values.push_back(value);
  }
  if (values.empty()) return 1;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return kMidGrey<double> / *middle;
}

std::uint8_t to_byte(double scaled) {
  if (!(scaled > 0)) return 0;
  return srgb8_from_linear(shoulder(scaled));
}

}  // namespace

Image8 tone_map(const ImageF& linear, std::optional<double> exposure) {
  if (linear.channels != 3) {
    throw ArgumentError(fmt::format("tone_map: {} channels, not 3", linear.channels));
  }
  const double scale = exposure ? std::exp2(*exposure) : metered_scale(linear);
  Image8 picture(linear.width, linear.height, 3);
  constexpr std::size_t kGrain = 1U << 16U;
  parallel_for(picture.pixels.size(), kGrain, 0, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) picture.pixels[i] = to_byte(scale * linear.pixels[i]);
  });
  return picture;
}

}  // namespace enfilade::image
