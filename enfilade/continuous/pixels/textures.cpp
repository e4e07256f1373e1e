#include "enfilade/continuous/pixels/textures.h"

#include <algorithm>

#include "enfilade/core/errors.h"
#include "enfilade/image/tone.h"

namespace enfilade::continuous::pixels {
namespace {

const std::array<float, 256>& linear_bytes() {
  static const std::array<float, 256> kTable = [] {
    std::array<float, 256> table;
    for (std::size_t i = 0; i < table.size(); ++i) {
      table[i] = image::linear_from_srgb(static_cast<float>(i) / 255);
    }
    return table;
  }();
  return kTable;
}

// srgb8_from_linear() takes a power for each texel; this is exact to a rounding at byte borders.
std::uint8_t srgb_byte(float light) {
  constexpr std::size_t kSteps = 1U << 14U;
  static const std::vector<std::uint8_t> kTable = [] {
    std::vector<std::uint8_t> table(kSteps + 1);
    for (std::size_t i = 0; i <= kSteps; ++i) {
      table[i] = image::srgb8_from_linear(static_cast<float>(i) / kSteps);
    }
    return table;
  }();
  return kTable[static_cast<std::size_t>(std::clamp(light, 0.0F, 1.0F) * kSteps + 0.5F)];
}

}  // namespace

std::uint32_t Textures::add(const image::Image8& texture) {
  first_level_.push_back(static_cast<std::uint32_t>(levels_.size()));
  const std::size_t first = levels_.size();
  const std::size_t texels = std::size_t{texture.width} * texture.height;
  constexpr std::size_t kMost = std::size_t{1} << 31U;
  if (texels_.size() + 2 * texels + 64 > kMost) {
    throw Error("textures: more than 2^31 texels in one mesh");
  }
  levels_.push_back({texture.width, texture.height, 0, static_cast<std::uint32_t>(texels_.size())});
  for (std::size_t i = 0; i < texels; ++i) {
    const std::uint8_t* p = texture.pixels.data() + i * texture.channels;
    const std::uint32_t alpha = texture.channels == 4 ? p[3] : 255;
    texels_.push_back(std::uint32_t{p[0]} | std::uint32_t{p[1]} << 8U | std::uint32_t{p[2]} << 16U |
                      alpha << 24U);
  }
  while (levels_.back().width > 1 || levels_.back().height > 1) add_half(Level(levels_.back()));
  for (std::size_t i = first; i < levels_.size(); ++i) {
    levels_[i].last = static_cast<std::uint32_t>(levels_.size() - 1 - i);
  }
  return static_cast<std::uint32_t>(first_level_.size() - 1);
}

void Textures::add_half(const Level& whole) {
  const auto& linear = linear_bytes();
  const Level half{std::max(whole.width / 2, 1U), std::max(whole.height / 2, 1U), 0,
                   static_cast<std::uint32_t>(texels_.size())};
  for (std::uint32_t y = 0; y < half.height; ++y) {
    for (std::uint32_t x = 0; x < half.width; ++x) {
      std::array<float, 3> sum{};
      for (const std::uint32_t dy : {0U, 1U}) {
        for (const std::uint32_t dx : {0U, 1U}) {
          const std::size_t row = std::min(2 * y + dy, whole.height - 1);
          const std::size_t column = std::min(2 * x + dx, whole.width - 1);
          const std::uint32_t texel = texels_[whole.first + row * whole.width + column];
          for (unsigned c = 0; c < 3; ++c) sum[c] += linear[texel >> 8 * c & 255U];
        }
      }
      std::uint32_t texel = 255U << 24U;
      for (unsigned c = 0; c < 3; ++c) {
        texel |= std::uint32_t{srgb_byte(0.25F * sum[c])} << 8 * c;
      }
      texels_.push_back(texel);
    }
  }
  levels_.push_back(half);
}

float Textures::alpha(std::uint32_t texture, float s, float t) const {
  const Level& level = levels_[first_level_[texture]];
  const Axis x = along(s, level.width), y = along(t, level.height);
  const auto texel = [&](std::uint32_t i, std::uint32_t j) {
    return static_cast<float>(texels_[level.first + std::size_t{j} * level.width + i] >> 24U);
  };
  const float across = static_cast<float>(x.share) / 256, down = static_cast<float>(y.share) / 256;
  const float top = std::lerp(texel(x.low, y.low), texel(x.high, y.low), across);
  const float bottom = std::lerp(texel(x.low, y.high), texel(x.high, y.high), across);
  return std::lerp(top, bottom, down) / 255;
}

}  // namespace enfilade::continuous::pixels
