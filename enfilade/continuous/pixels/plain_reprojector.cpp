#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "enfilade/continuous/pixels/photo.h"

namespace enfilade::continuous::pixels {
namespace {

// Where a direction of the panorama's frame meets its cube.
struct OnFace {
  std::int32_t face;
  float across, down;  ///< of the face, -1 .. 1
  float along;         ///< the direction's length along the face's axis
};

OnFace on_face(Vec3f d) {
  const float x = std::max(std::abs(d.x), kLeastAlong), y = std::max(std::abs(d.y), kLeastAlong),
              z = std::max(std::abs(d.z), kLeastAlong);
  if (y >= x && y >= z) return {d.y < 0 ? 0 : 5, -d.x / y, (d.y < 0 ? -d.z : d.z) / y, y};
  if (x >= z) return {d.x < 0 ? 2 : 4, (d.x < 0 ? d.z : -d.z) / x, d.y / x, x};
  return {d.z < 0 ? 1 : 3, (d.z < 0 ? -d.x : d.x) / z, d.y / z, z};
}

// Four texels of a bordered face, and the shares of the right and the lower ones.
struct Taps {
  std::int32_t first, pitch;
  float right, below;
};
Taps taps_of(const OnFace& at, std::int32_t size) {
  const float half = 0.5F * static_cast<float>(size), middle = half + 0.5F;
  const float x = at.across * half + middle, y = at.down * half + middle;
  const auto i = std::clamp(static_cast<std::int32_t>(x), 0, size);
  const auto j = std::clamp(static_cast<std::int32_t>(y), 0, size);
  const std::int32_t pitch = size + 2;
  return {(at.face * pitch + j) * pitch + i, pitch, x - static_cast<float>(i),
          y - static_cast<float>(j)};
}

template <class Value>
float bilinear(const Taps& taps, const Value& value) {
  const float top = (1 - taps.right) * value(taps.first) + taps.right * value(taps.first + 1);
  const float bottom = (1 - taps.right) * value(taps.first + taps.pitch) +
                       taps.right * value(taps.first + taps.pitch + 1);
  return (1 - taps.below) * top + taps.below * bottom;
}

struct Blend {
  float weight = 0;
  Vec3f colour;  ///< times weight
};

void add(const Photo& photo, Vec3f point, Vec3f from_eye, float spread, Blend& blend) {
  const Vec3f way = point - photo.centre;
  const OnFace at = on_face({dot(way, photo.right), dot(way, photo.down), dot(way, photo.forward)});
  const auto size = static_cast<std::int32_t>(photo.size);
  const float there = bilinear(taps_of(at, size), [&](std::int32_t k) {
    return photo.nearness[static_cast<std::size_t>(k)];
  });
  const float expected = 1 / at.along;
  if (!(std::abs(there - expected) <= kSamePart * expected + kSameNearness)) return;
  const float eye_square = dot(from_eye, from_eye), square = dot(way, way);
  const float cosine = dot(from_eye, way) / std::sqrt(eye_square * square);
  const float farther = std::sqrt(square / eye_square);  // than the eye
  const float penalty = (1 - cosine) + kCoarseness * std::max(farther - 1, 0.0F) + kLeastPenalty;
  const float weight = 1 / (penalty * penalty);
  // Texels of the photo that the eye's pixel covers.
  const float texels = spread * static_cast<float>(size) / (2 * farther);
  std::int32_t level = 0;
  if (texels > 1) {
    const auto bits = std::bit_cast<std::int32_t>(texels) - (127 << 23);
    level = std::min((bits + (1 << 22)) >> 23, static_cast<std::int32_t>(photo.levels) - 1);
  }
  const Taps taps = taps_of(at, size >> level);
  const std::uint32_t* const colours =
      photo.colours.data() + photo.first[static_cast<std::size_t>(level)];
  const auto part = [&](unsigned shift) {
    return bilinear(taps,
                    [&](std::int32_t k) { return static_cast<float>(colours[k] >> shift & 255U); });
  };
  blend.weight += weight;
  blend.colour += weight * Vec3f{part(0), part(8), part(16)};
}

std::uint32_t byte_of(float x) { return static_cast<std::uint32_t>(x + 0.5F); }

}  // namespace

std::uint64_t reproject_plainly(const TileColours& tile, std::span<const Photo* const> photos,
                                std::uint32_t* rgba) {
  std::uint64_t left = 0;
  const Surfaces& surfaces = tile.scene.surfaces;
  for (std::size_t k = 0; k < kTilePixels; ++k) {
    const std::int32_t triangle = tile.triangle[k];
    const float distance = triangle < 0 ? kSkyDistance : 1 / tile.nearness[k];
    const bool mirror =
        triangle >= 0 &&
        surfaces.paints[surfaces.all[static_cast<std::size_t>(triangle)].paint].mirror > 0;
    const Vec3f way = distance * Vec3f{tile.towards.x[k], tile.towards.y[k], tile.towards.z[k]};
    Blend blend;
    for (const Photo* photo : photos) add(*photo, tile.eye.whole + way, way, tile.spread, blend);
    if (mirror || !(blend.weight > 0)) {
      left |= std::uint64_t{1} << k;
      continue;
    }
    const Vec3f c{blend.colour.x / blend.weight, blend.colour.y / blend.weight,
                  blend.colour.z / blend.weight};
    rgba[k] = byte_of(c.x) | byte_of(c.y) << 8U | byte_of(c.z) << 16U | 255U << 24U;
  }
  return left;
}

}  // namespace enfilade::continuous::pixels
