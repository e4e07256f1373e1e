#include "enfilade/continuous/pixels/surfaces.h"

#include <algorithm>
#include <cmath>

#include "enfilade/core/errors.h"
#include "enfilade/image/tone.h"

namespace enfilade::continuous::pixels {
namespace {

using mesh::Mesh;

struct Corners {
  std::array<std::size_t, 3> of;  ///< the mesh's corners, by ours
  Vec3d origin, u, v;             ///< corner 0, and the edges to the others
};

Corners corners_of(const Mesh& mesh, std::size_t triangle) {
  std::array<Vec3d, 3> at;
  for (std::size_t k = 0; k < 3; ++k) {
    at[k] = to_double(mesh.positions[mesh.triangles[triangle][k]]);
  }
  std::size_t first = 0;
  double longest = -1;
  for (std::size_t k = 0; k < 3; ++k) {
    const double opposite = length(at[(k + 2) % 3] - at[(k + 1) % 3]);
    if (opposite <= longest) continue;
    longest = opposite;
    first = k;
  }
  const std::array<std::size_t, 3> of{first, (first + 1) % 3, (first + 2) % 3};
  return {of, at[of[0]], at[of[1]] - at[of[0]], at[of[2]] - at[of[0]]};
}

Surface surface_of(const Mesh& mesh, std::size_t triangle) {
  const Corners c = corners_of(mesh, triangle);
  Surface s;
  s.origin = to_float(c.origin);
  s.first_corner = static_cast<std::uint8_t>(c.of[0]);
  const Vec3d normal = cross(c.u, c.v);
  const double square = dot(normal, normal);
  s.normal = {0, 0, 1};
  if (square > 0) {
    s.normal = to_float(1 / std::sqrt(square) * normal);
    s.along_u = to_float(1 / square * cross(c.v, normal));
    s.along_v = to_float(1 / square * cross(normal, c.u));
  }
  s.paint = mesh.triangle_material[triangle];
  if (const std::uint32_t object = mesh::object_of(mesh, triangle); object != mesh::kNoObject) {
    s.category = mesh.objects[object].category;
    s.instance = object + 1;
  }
  if (!mesh.texture_points.empty()) {
    const auto& points = mesh.texture_points[triangle];
    const auto &a = points[c.of[0]], &b = points[c.of[1]], &d = points[c.of[2]];
    // Whole repetitions are taken off, which keeps the digits for what is left.
    s.s0 = a.u - std::floor(a.u);
    s.t0 = a.v - std::floor(a.v);
    s.su = b.u - a.u;
    s.tu = b.v - a.v;
    s.sv = d.u - a.u;
    s.tv = d.v - a.v;
  }
  return s;
}

// The square root of the triangle's area in texels over that in space.
float texels_per_metre(const Surface& s, float width, float height) {
  const Vec3f across = cross(s.along_u, s.along_v);  // its length: 1 / twice the area
  return std::sqrt(std::abs(s.su * s.tv - s.sv * s.tu) * width * height * length(across));
}

// What a material reflects and emits.
void set_light(const mesh::Material& material, float least_mirror, Paint& paint) {
  paint.colour = (1 - material.mirror) * material.colour;
  paint.emission = material.emission;
  if (material.mirror < least_mirror) {
    constexpr float kAround = 0.5F;  // about what a room reflects
    paint.gloss = kAround * material.mirror;
  } else {
    paint.mirror = material.mirror;
  }
}

}  // namespace

Surfaces::Surfaces(const Mesh& mesh, float least_mirror, Values values)
    : textures(values), light{pack_light({}), pack_light({1, 1, 1})} {
  for (const mesh::Material& material : mesh.materials) {
    Paint paint;
    if (values == Values::kDisplay) {
      paint.colour = material.colour;
    } else {
      set_light(material, least_mirror, paint);
    }
    if (!material.texture.pixels.empty() && !mesh.texture_points.empty()) {
      paint.texture = textures.add(material.texture);
      if (material.texture.channels == 4) paint.cutout = material.cutout;
    }
    paints.push_back(paint);
  }
  all.reserve(mesh.triangles.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    Surface s = surface_of(mesh, t);
    if (const std::uint32_t texture = paints[s.paint].texture; texture != Paint::kNoTexture) {
      const float width = textures.width(texture), height = textures.height(texture);
      s.texels_per_metre = texels_per_metre(s, width, height);
      s.along_s = width * (s.su * s.along_u + s.sv * s.along_v);
      s.along_t = height * (s.tu * s.along_u + s.tv * s.along_v);
    }
    s.front = s.back = kWhite;
    if (!mesh.colours.empty()) {
      const auto colour = [&](unsigned k) {
        return mesh.colours[mesh.triangles[t][(s.first_corner + k) % 3U]];
      };
      const Vec3f a = colour(0), b = colour(1), c = colour(2);
      s.front = s.back = static_cast<std::uint32_t>(light.size());
      s.cells_u = s.cells_v = 1;
      // The fourth value continues the triangle's plane.
      for (const Vec3f x : {a, b, c, b + c - a}) light.push_back(pack_light(x));
    }
    all.push_back(s);
  }
}

LinearTable::LinearTable(Values values) {
  for (std::size_t i = 0; i < values_.size(); ++i) {
    const float shown = std::min(static_cast<float>(i) / (4 * 255), 1.0F);
    values_[i] = values == Values::kDisplay ? shown : image::linear_from_srgb(shown);
  }
}

ToneTable::ToneTable(Curve curve) {
  for (std::uint32_t i = 0; i < bytes_.size(); ++i) {
    // The middle of the values that share the entry.
    const std::uint32_t bits = kLeastBits + (i << kDropped) + (1U << (kDropped - 1));
    const auto light = std::bit_cast<float>(bits);
    if (curve == Curve::kDisplay) {
      bytes_[i] = static_cast<std::uint32_t>(std::min(light, 1.0F) * 255 + 0.5F);
    } else {
      bytes_[i] =
          image::srgb8_from_linear(curve == Curve::kShoulder ? image::shoulder(light) : light);
    }
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
  while (levels_.back().width > 1 || levels_.back().height > 1)
    add_half(TextureLevel(levels_.back()));
  for (std::size_t i = first; i < levels_.size(); ++i) {
    levels_[i].last = static_cast<std::uint32_t>(levels_.size() - 1 - i);
  }
  return static_cast<std::uint32_t>(first_level_.size() - 1);
}

void Textures::add_half(const TextureLevel& whole) {
  const bool display = values_ == Values::kDisplay;
  const auto& linear = image::linear_bytes();
  const TextureLevel half{std::max(whole.width / 2, 1U), std::max(whole.height / 2, 1U), 0,
                          static_cast<std::uint32_t>(texels_.size())};
  for (std::uint32_t y = 0; y < half.height; ++y) {
    for (std::uint32_t x = 0; x < half.width; ++x) {
      std::array<float, 3> sum{};
      for (const std::uint32_t dy : {0U, 1U}) {
        for (const std::uint32_t dx : {0U, 1U}) {
          const std::size_t row = std::min(2 * y + dy, whole.height - 1);
          const std::size_t column = std::min(2 * x + dx, whole.width - 1);
          const std::uint32_t texel = texels_[whole.first + row * whole.width + column];
          for (unsigned c = 0; c < 3; ++c) {
            const std::uint32_t byte = texel >> 8 * c & 255U;
            sum[c] += display ? static_cast<float>(byte) : linear[byte];
          }
        }
      }
      std::uint32_t texel = 255U << 24U;
      for (unsigned c = 0; c < 3; ++c) {
        const float mean = 0.25F * sum[c];
        texel |= (display ? static_cast<std::uint32_t>(mean + 0.5F)
                          : std::uint32_t{image::srgb_byte(mean)})
                 << 8 * c;
      }
      texels_.push_back(texel);
    }
  }
  levels_.push_back(half);
}

float Textures::alpha(std::uint32_t texture, float s, float t) const {
  const TextureLevel& level = levels_[first_level_[texture]];
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
