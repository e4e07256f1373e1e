#include <fmt/format.h>
#include <algorithm>
#include <cmath>

#include "enfilade/core/threads.h"
#include "enfilade/image/codecs.h"

namespace enfilade::image {
namespace {

constexpr double kMidGrey = 0.18;  // what a light meter takes the world for

// ITU-R BT.709
double luminance(const float* rgb) { return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]; }

// What to multiply by so that the median becomes mid-grey. Black pixels tell nothing (a studio's
// panorama may be mostly black).
double metered_scale(const ImageF& linear) {
  std::vector<float> values;
  values.reserve(linear.pixels.size() / 3);
  for (std::size_t i = 0; i < linear.pixels.size(); i += 3) {
    const auto value = static_cast<float>(luminance(linear.pixels.data() + i));
    if (value > 0 && std::isfinite(value)) values.push_back(value);
  }
  if (values.empty()) return 1;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return kMidGrey / *middle;
}

// Straight up to the knee, then bent towards white, which it never quite reaches: bright windows
// keep their shapes. Value and slope are continuous.
double shoulder(double x) {
  constexpr double kKnee = 0.4;
  return x <= kKnee ? x : kKnee + (1 - kKnee) * (1 - std::exp(-(x - kKnee) / (1 - kKnee)));
}

// IEC 61966-2-1
double srgb(double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * std::pow(x, 1 / 2.4) - 0.055; }

std::uint8_t to_byte(double scaled) {
  if (!(scaled > 0)) return 0;
  return static_cast<std::uint8_t>(std::lround(255 * srgb(std::min(shoulder(scaled), 1.0))));
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
