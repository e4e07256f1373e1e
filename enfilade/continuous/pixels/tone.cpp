#include "enfilade/continuous/pixels/tone.h"

#include <cmath>

#include "enfilade/image/tone.h"

namespace enfilade::continuous::pixels {

LinearTable::LinearTable() {
  for (std::size_t i = 0; i < values_.size(); ++i) {
    values_[i] = image::linear_from_srgb(std::min(static_cast<float>(i) / (4 * 255), 1.0F));
  }
}

ToneTable::ToneTable(Curve curve) {
  for (std::uint32_t i = 0; i < bytes_.size(); ++i) {
    // The middle of the values that share the entry.
    const std::uint32_t bits = kLeastBits + (i << kDropped) + (1U << (kDropped - 1));
    const auto light = std::bit_cast<float>(bits);
    bytes_[i] =
        image::srgb8_from_linear(curve == Curve::kShoulder ? image::shoulder(light) : light);
  }
}

std::uint32_t pack_light(Vec3f light) {
  static constexpr float kLargest = 65408;  // 511 / 512 * 2^16
  const auto part = [](float x) { return std::clamp(x, 0.0F, kLargest); };
  const Vec3f c{part(light.x), part(light.y), part(light.z)};
  const float most = std::max({c.x, c.y, c.z});
  int exponent = 0;
  std::frexp(most, &exponent);                // most < 2^exponent
  int shared = std::max(exponent, -15) + 15;  // 0 .. 31
  // Rounding may carry into a tenth bit.
  if (std::lround(std::ldexp(most, 24 - shared)) > 511) ++shared;
  const auto bits = [shared](float x) {
    return static_cast<std::uint32_t>(std::lround(std::ldexp(x, 24 - shared)));
  };
  return bits(c.x) | bits(c.y) << 9U | bits(c.z) << 18U | static_cast<std::uint32_t>(shared) << 27U;
}

}  // namespace enfilade::continuous::pixels
