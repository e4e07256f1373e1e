#include "enfilade/mesh/detail/textures.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "enfilade/image/tone.h"
#include "enfilade/mesh/detail/vector.h"

namespace enfilade::mesh::detail {
namespace {

const std::array<float, 256> kLinear = image::linear_bytes();

Vec3f colour_of(std::uint32_t texel) {
  return {kLinear[texel & 255U], kLinear[texel >> 8U & 255U], kLinear[texel >> 16U & 255U]};
}
std::uint32_t texel_of(Vec3f colour) {
  const auto byte = [](float linear) { return std::uint32_t{image::srgb8_from_linear(linear)}; };
  return byte(colour.x) | byte(colour.y) << 8U | byte(colour.z) << 16U;
}

// The two texels around a place along one axis, and the second one's share.
struct Between {
  std::uint32_t low = 0, high = 0;
  float share = 0;
};
Between between_texels(float at, std::uint32_t size) {
  const auto n = static_cast<float>(size);
  const float x = (at - std::floor(at)) * n - 0.5F;
  const float whole = std::floor(x);
  const auto i = static_cast<std::int64_t>(whole);
  const auto low =
      static_cast<std::uint32_t>(i < 0 ? size - 1 : std::min<std::int64_t>(i, size - 1));
  return {low, low + 1 < size ? low + 1 : 0, x - whole};
}

}  // namespace

float linear_of(std::uint8_t byte) { return kLinear[byte]; }

TexturePoint texture_point(const Mesh& mesh, std::uint32_t triangle, float u, float v) {
  if (mesh.texture_points.empty()) return {};
  const auto& [a, b, c] = mesh.texture_points[triangle];
  const float w = 1 - u - v;
  return {w * a.u + u * b.u + v * c.u, w * a.v + u * b.v + v * c.v};
}

float alpha_at(const image::Image8& texture, TexturePoint at) {
  const Between x = between_texels(at.u, texture.width), y = between_texels(at.v, texture.height);
  const auto alpha = [&](std::uint32_t i, std::uint32_t j) {
    return static_cast<float>(texture.at(i, j)[3]);
  };
  const float top = std::lerp(alpha(x.low, y.low), alpha(x.high, y.low), x.share);
  const float bottom = std::lerp(alpha(x.low, y.high), alpha(x.high, y.high), x.share);
  return std::lerp(top, bottom, y.share) / 255;
}

TexturePyramid::TexturePyramid(const image::Image8& texture) {
  Level& whole = levels_.emplace_back(Level{texture.width, texture.height, {}});
  const std::size_t texels = std::size_t{texture.width} * texture.height;
  whole.texels.resize(texels);
  for (std::size_t i = 0; i < texels; ++i) {
    const std::uint8_t* p = texture.pixels.data() + i * texture.channels;
    whole.texels[i] = std::uint32_t{p[0]} | std::uint32_t{p[1]} << 8U | std::uint32_t{p[2]} << 16U;
  }
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    levels_.push_back(half(levels_.back()));
  }
  mean_ = colour_of(levels_.back().texels.front());
}

TexturePyramid::Level TexturePyramid::half(const Level& whole) {
  Level made{std::max(whole.width / 2, 1U), std::max(whole.height / 2, 1U), {}};
  made.texels.reserve(std::size_t{made.width} * made.height);
  for (std::uint32_t y = 0; y < made.height; ++y) {
    for (std::uint32_t x = 0; x < made.width; ++x) {
      Vec3f sum;
      for (const std::uint32_t dy : {0U, 1U}) {
        for (const std::uint32_t dx : {0U, 1U}) {
          const std::size_t row = std::min(2 * y + dy, whole.height - 1);
          sum += colour_of(whole.texels[row * whole.width + std::min(2 * x + dx, whole.width - 1)]);
        }
      }
      made.texels.push_back(texel_of(0.25F * sum));
    }
  }
  return made;
}

Vec3f TexturePyramid::between(const Level& level, TexturePoint point) {
  const Between x = between_texels(point.u, level.width);
  const Between y = between_texels(point.v, level.height);
  const std::uint32_t* top = level.texels.data() + std::size_t{y.low} * level.width;
  const std::uint32_t* bottom = level.texels.data() + std::size_t{y.high} * level.width;
  return mix(mix(colour_of(top[x.low]), colour_of(top[x.high]), x.share),
             mix(colour_of(bottom[x.low]), colour_of(bottom[x.high]), x.share), y.share);
}

Vec3f TexturePyramid::at(TexturePoint point, float texels) const {
  const float level =
      texels > 1 ? std::min(std::log2(texels), static_cast<float>(levels_.size() - 1)) : 0;
  const auto below = static_cast<std::size_t>(level);
  const float share = level - static_cast<float>(below);
  const Vec3f fine = between(levels_[below], point);
  if (share <= 0) return fine;
  return mix(fine, between(levels_[below + 1], point), share);
}

}  // namespace enfilade::mesh::detail
