/// \file  Textures in halved sizes, as sRGB bytes, for quick filtering.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/image/image.h"

namespace enfilade::continuous::pixels {

/// R, G and B of a filtered texel in 1 / 256 of a byte's step of sRGB.
struct Filtered {
  std::array<std::uint32_t, 3> parts;
};

/// Textures of one mesh. Filtering mixes sRGB bytes, not light: three table lookups instead of
/// twelve; halved sizes are means of light.
class Textures {
 public:
  /// Appends a texture. \returns its number  \pre 3 or 4 channels, at least a texel
  /// \throws Error for more than 2^31 texels in all
  std::uint32_t add(const image::Image8& texture);
  std::size_t size() const noexcept { return first_level_.size(); }
  std::size_t bytes() const noexcept { return 4 * texels_.capacity(); }

  /// Width of the largest size, texels.
  float width(std::uint32_t texture) const {
    return static_cast<float>(levels_[first_level_[texture]].width);
  }
  float height(std::uint32_t texture) const {
    return static_cast<float>(levels_[first_level_[texture]].height);
  }

  /// The mean over about `texels` texels of the texture across, around (s, t), which repeats.
  Filtered at(std::uint32_t texture, float s, float t, float texels) const {
    const Level* const level = levels_.data() + first_level_[texture];
    const std::uint32_t last = level->last;
    // Halvings in 1 / 256: the bits of a float are its logarithm, nearly linear between powers.
    std::uint32_t halvings = 0;
    if (texels > 1) {
      const auto bits = std::bit_cast<std::uint32_t>(texels) - (127U << 23U);
      halvings = std::min(bits >> 15U, last << 8U);
    }
    const std::uint32_t fine = halvings >> 8U, share = halvings & 255U;
    const Fields low = between(level[fine], s, t);
    if (share == 0) return {{part(low, 0), part(low, 1), part(low, 2)}};
    const Fields high = between(level[fine + 1], s, t);
    const auto mixed = [&](unsigned c) {
      return (part(low, c) * (256 - share) + part(high, c) * share) >> 8U;
    };
    return {{mixed(0), mixed(1), mixed(2)}};
  }
  /// Alpha in [0, 1], bilinear, of the largest size.
  float alpha(std::uint32_t texture, float s, float t) const;

  /// One size of a texture.
  struct Level {
    std::uint32_t width, height;
    std::uint32_t last;   ///< how many smaller ones follow
    std::uint32_t first;  ///< of its texels
  };
  /// For vector instructions.
  struct Tables {
    const std::uint32_t* first_level;  ///< by texture
    const Level* levels;
    const std::uint32_t* texels;  ///< R lowest
  };
  Tables tables() const { return {first_level_.data(), levels_.data(), texels_.data()}; }

 private:
  // R, B, G and A of a texel in 16 bits each.
  using Fields = std::uint64_t;
  static Fields spread(std::uint32_t texel) {
    return (texel & 0x00FF00FFU) | static_cast<Fields>(texel & 0xFF00FF00U) << 24U;
  }
  static std::uint32_t part(Fields fields, unsigned channel) {
    constexpr std::array<unsigned, 3> kShift{0, 32, 16};
    return static_cast<std::uint32_t>(fields >> kShift[channel] & 0xFFFFU);
  }
  struct Axis {
    std::uint32_t low, high, share;  ///< of the second, of 256
  };
  static Axis along(float at, std::uint32_t size) {
    const auto n = static_cast<float>(size);
    // + size keeps it positive, so that the conversion rounds down.
    const float x = (at - std::floor(at)) * n + (n - 0.5F);
    auto whole = static_cast<std::uint32_t>(x);
    const auto share = static_cast<std::uint32_t>((x - static_cast<float>(whole)) * 256);
    whole -= size;  // -1 becomes a large number
    const std::uint32_t low = whole < size ? whole : size - 1;
    return {low, low + 1 < size ? low + 1 : 0, share};
  }
  Fields between(const Level& level, float s, float t) const {
    const Axis x = along(s, level.width), y = along(t, level.height);
    const std::uint32_t* const top =
        texels_.data() + level.first + std::size_t{y.low} * level.width;
    const std::uint32_t* const bottom =
        texels_.data() + level.first + std::size_t{y.high} * level.width;
    // Of 256 in all, so that 16 bits hold a byte times that.
    const Fields both = (x.share * y.share) >> 8U, right = x.share - both, below = y.share - both;
    return spread(top[x.low]) * (256 - x.share - below) + spread(top[x.high]) * right +
           spread(bottom[x.low]) * below + spread(bottom[x.high]) * both;
  }
  void add_half(const Level& whole);

  std::vector<std::uint32_t> first_level_;
  std::vector<Level> levels_;
  std::vector<std::uint32_t> texels_;
};

}  // namespace enfilade::continuous::pixels
