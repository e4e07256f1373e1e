/// \file  Data of each triangle for rendering: its position, its texture, its light. Textures in
/// halved sizes (mip maps). From linear light to bytes and back, by tables.
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "enfilade/geometry/vec.h"
#include "enfilade/image/image.h"
#include "enfilade/mesh/mesh.h"

namespace enfilade::continuous::pixels {

/// What the colours of surfaces are while they are computed.
enum class Values : std::uint8_t {
  kLinear,   ///< linear light
  kDisplay,  ///< bytes of pictures / 255
};

/// Texels are filtered as bytes in 1 / 256 of a step; this has the values of quarter steps.
class LinearTable {
 public:
  explicit LinearTable(Values values);
  /// \param value in 1 / 256 of a byte's step, at most 255 * 256
  float of(std::uint32_t value) const { return values_[value >> 6U]; }
  const float* table() const { return values_.data(); }

 private:
  std::array<float, 1024> values_;
};

/// Bytes of colours: sRGB of linear light, with or without the tone curve of pictures of lit
/// meshes, or display values as they are. A value is looked up by its exponent and the first eight
/// bits of its fraction, which is finer than a byte's step.
class ToneTable {
 public:
  /// With image::shoulder(), plain sRGB, or none.
  enum class Curve : std::uint8_t { kShoulder, kPlain, kDisplay };
  explicit ToneTable(Curve curve);

  std::uint8_t of(float light) const {
    if (!(light >= kLeast)) return 0;
    const auto bits = std::bit_cast<std::uint32_t>(std::min(light, kMost));
    return static_cast<std::uint8_t>(bytes_[(bits - kLeastBits) >> kDropped]);
  }
  /// RGBA, R lowest, A = 255.
  std::uint32_t rgba(Vec3f light) const {
    return std::uint32_t{of(light.x)} | std::uint32_t{of(light.y)} << 8U |
           std::uint32_t{of(light.z)} << 16U | 255U << 24U;
  }

  const std::uint32_t* table() const { return bytes_.data(); }
  static constexpr std::uint32_t kDropped = 15;
  static constexpr float kLeast = 1.0F / (1U << 14U);  // below: byte 0
  static constexpr float kMost = 31.9F;                // above: byte 255 with each curve
  static constexpr auto kLeastBits = std::bit_cast<std::uint32_t>(kLeast);
  static constexpr auto kMostBits = std::bit_cast<std::uint32_t>(kMost);

 private:
  // As 32 bits each, which is what vector instructions gather.
  std::array<std::uint32_t, ((kMostBits - kLeastBits) >> kDropped) + 1> bytes_;
};

/// Colours of light in 32 bits: a common exponent and nine bits each (as OpenGL's RGB9_E5). The
/// error is at most 1 / 512 of the largest part. \pre parts are not negative
std::uint32_t pack_light(Vec3f light);
inline Vec3f unpack_light(std::uint32_t packed) {
  // 2^(exponent - 15 - 9) as a float's bits.
  const float scale = std::bit_cast<float>(((packed >> 27U) + (127 - 24)) << 23U);
  return {scale * static_cast<float>(packed & 511U),
          scale * static_cast<float>(packed >> 9U & 511U),
          scale * static_cast<float>(packed >> 18U & 511U)};
}

/// R, G and B of a filtered texel in 1 / 256 of a byte's step of sRGB.
struct Filtered {
  std::array<std::uint32_t, 3> parts;
};

/// Textures of one mesh. Filtering mixes sRGB bytes, not light: three table lookups instead of
/// twelve; halved sizes are means of light, or of bytes.
class Textures {
 public:
  explicit Textures(Values values) : values_(values) {}
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
    const TextureLevel* const level = levels_.data() + first_level_[texture];
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
  struct TextureLevel {
    std::uint32_t width, height;
    std::uint32_t last;   ///< how many smaller ones follow
    std::uint32_t first;  ///< of its texels
  };
  /// For vector instructions.
  struct Tables {
    const std::uint32_t* first_level;  ///< by texture
    const TextureLevel* levels;
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
  Fields between(const TextureLevel& level, float s, float t) const {
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
  void add_half(const TextureLevel& whole);

  Values values_;
  std::vector<std::uint32_t> first_level_;
  std::vector<TextureLevel> levels_;
  std::vector<std::uint32_t> texels_;
};

/// Least sine of the angle between a line of sight and a surface, for the size of a pixel's
/// footprint there.
inline constexpr float kLeastSlant = 0.05F;

/// A triangle. Its corners are numbered from the one opposite the longest edge on. So the two edges
/// that meet there are the legs of a grid that wastes little.
struct alignas(64) Surface {
  Vec3f origin;            ///< corner 0
  Vec3f along_u, along_v;  ///< a point's weight of corner 1 is dot(along_u, point - origin)
  Vec3f normal;            ///< length 1, on the front
  float s0 = 0, t0 = 0, su = 0, tu = 0, sv = 0, tv = 0;  ///< texture point: s0 + u su + v sv
  float texels_per_metre = 0;
  std::uint32_t paint = 0;                 ///< in Surfaces::paints
  std::uint32_t front = 0, back = 0;       ///< first value of its light on either side
  std::uint16_t cells_u = 0, cells_v = 0;  ///< light is in (cells_u + 1) (cells_v + 1) values
  std::uint16_t category = 0;
  std::uint8_t first_corner = 0;  ///< of the mesh's triangle
  std::uint32_t instance = 0;
  Vec3f along_s, along_t;  ///< a step crosses dot(along_s, step) texels of a row, along_t: a column
};
static_assert(sizeof(Surface) == 128);

/// A material.
struct Paint {
  static constexpr std::uint32_t kNoTexture = 0xFFFFFFFFU;
  Vec3f colour;     ///< without the share that is reflected as by a mirror
  float gloss = 0;  ///< added for such a reflection, if it is small
  Vec3f emission;
  float mirror = 0;  ///< reflected so
  float cutout = 0;  ///< 0: none
  std::uint32_t texture = kNoTexture;
};

/// Weights of corners 1 and 2.
struct Weights {
  float u, v;
};
/// In [0, 1]; 0 for NaN.
inline float share(float weight) { return weight > 0 ? std::min(weight, 1.0F) : 0; }
/// \param from from the surface's origin
inline Weights weights_at(const Surface& surface, Vec3f from) {
  return {share(dot(surface.along_u, from)), share(dot(surface.along_v, from))};
}

/// All triangles of a mesh.
class Surfaces {
 public:
  /// Light 1 on both sides, times the mesh's colours. \pre mesh passes check()
  /// \param least_mirror  less is gloss
  /// \param values  display values neither shine nor reflect
  Surfaces(const mesh::Mesh& mesh, float least_mirror, Values values);

  /// One of kDark and kWhite is at these places of `light`.
  static constexpr std::uint32_t kDark = 0, kWhite = 1;

  std::vector<Surface> all;  ///< by triangle
  std::vector<Paint> paints;
  Textures textures;
  std::vector<std::uint32_t> light;  ///< pack_light(), times the mesh's colours

  /// Whether there is a surface at this point of a triangle, whose texture may have holes.
  bool is_there(std::uint32_t triangle, Weights at) const {
    const Surface& s = all[triangle];
    const Paint& paint = paints[s.paint];
    return paint.cutout <= 0 || textures.alpha(paint.texture, s.s0 + at.u * s.su + at.v * s.sv,
                                               s.t0 + at.u * s.tu + at.v * s.tv) >= paint.cutout;
  }
  bool has_holes(std::uint32_t triangle) const { return paints[all[triangle].paint].cutout > 0; }
};

/// The light on one side of a surface, bilinear. \param first of its values
inline Vec3f light_at(const std::uint32_t* light, const Surface& surface, std::uint32_t first,
                      Weights at) {
  light += first;
  if (first <= Surfaces::kWhite) return unpack_light(*light);
  const float x = at.u * static_cast<float>(surface.cells_u);
  const float y = at.v * static_cast<float>(surface.cells_v);
  const std::uint32_t i = std::min<std::uint32_t>(static_cast<std::uint32_t>(x),
                                                  surface.cells_u == 0 ? 0 : surface.cells_u - 1U);
  const std::uint32_t j = std::min<std::uint32_t>(static_cast<std::uint32_t>(y),
                                                  surface.cells_v == 0 ? 0 : surface.cells_v - 1U);
  const float a = x - static_cast<float>(i), b = y - static_cast<float>(j);
  const std::uint32_t pitch = surface.cells_u + 1U;
  const std::uint32_t* const low = light + std::size_t{j} * pitch + i;
  const std::uint32_t* const high = low + (surface.cells_v == 0 ? 0 : pitch);
  const std::uint32_t next = surface.cells_u == 0 ? 0 : 1;
  return (1 - b) * ((1 - a) * unpack_light(low[0]) + a * unpack_light(low[next])) +
         b * ((1 - a) * unpack_light(high[0]) + a * unpack_light(high[next]));
}

}  // namespace enfilade::continuous::pixels
