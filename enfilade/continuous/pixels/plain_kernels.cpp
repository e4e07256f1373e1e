#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "enfilade/continuous/pixels/photo.h"
#include "enfilade/continuous/pixels/rasteriser.h"

namespace enfilade::continuous::pixels {
namespace {

// x a + y b + c, in the order of operations that all versions have.
float at(Vec3f line, float x, float y) { return (line.x * x + line.y * y) + line.z; }

// What a triangle covers: pixels of the tiles that its box meets, where no edge is negative.
struct Flat {
  std::array<Vec3f, 3> edges;
  Vec3f nearness;
  std::uint32_t column0 = 0, column1 = 0, row0 = 0, row1 = 0;
};

class Drawer {
 public:
  Drawer(const RasterView& sight, TileRows rows, VisibilityBuffer& frame)
      : sight_(sight),
        lattice_(sight.lattice),
        eye_(sight.eye),
        rows_(rows),
        frame_(frame),
        most_nearness_(sight.most_nearness()) {}

  void draw(const Bundle& bundle, std::size_t i) {
    std::array<Vec3f, 3> v;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto& at = bundle.corner[k];
      const Vec3f c = (Vec3f{at[0][i], at[1][i], at[2][i]} - eye_.whole) - eye_.rest;
      v[k] = {dot(c, eye_.right), dot(c, eye_.down), dot(c, eye_.forward)};
    }
    Flat flat;
    if (!flatten(v, flat)) return;
    for (std::uint32_t row = flat.row0; row <= flat.row1; ++row) {
      for (std::uint32_t column = flat.column0; column <= flat.column1; ++column) {
        draw_pixel(bundle, i, flat, column, row);
      }
    }
  }

 private:
  bool flatten(const std::array<Vec3f, 3>& v, Flat& flat) const {
    const Vec3f normal = cross(v[1] - v[0], v[2] - v[0]);
    const float volume = dot(normal, v[0]);
    if (!(std::abs(volume) > 0) || (sight_.fronts_only && volume > 0)) return false;
    const float sign = std::signbit(volume) ? -1.0F : 1.0F;
    flat.nearness = (1 / std::abs(volume)) * (sign * normal);
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3f a = v[(k + 1) % 3], b = v[(k + 2) % 3];
      flat.edges[k] = sign * cross(a - b, a + b);
    }
    if (std::max({v[0].z, v[1].z, v[2].z}) <= 0) return false;
    return find_box(v, flat);
  }

  bool find_box(const std::array<Vec3f, 3>& v, Flat& flat) const {
    const auto last_column = static_cast<float>(lattice_.width - 1);
    const auto first_row = static_cast<float>(rows_.begin * kTile);
    const auto last_row = static_cast<float>(std::min(rows_.end * kTile, lattice_.height) - 1);
    float x0 = 0, x1 = last_column, y0 = first_row, y1 = last_row;
    if (std::min({v[0].z, v[1].z, v[2].z}) >= kLeastDepth) {
      std::array<float, 3> x, y;
      for (std::size_t k = 0; k < 3; ++k) {
        const float scale = lattice_.focal / v[k].z;
        x[k] = v[k].x * scale + lattice_.centre_x;
        y[k] = v[k].y * scale + lattice_.centre_y;
      }
      x0 = std::max(std::ceil(std::ranges::min(x) - kBoxSlack), x0);
      x1 = std::min(std::floor(std::ranges::max(x) + kBoxSlack), x1);
      y0 = std::max(std::ceil(std::ranges::min(y) - kBoxSlack), y0);
      y1 = std::min(std::floor(std::ranges::max(y) + kBoxSlack), y1);
    }
    if (!(x0 <= x1 && y0 <= y1)) return false;
    // Whole tiles.
    const auto first = [](float pixel) {
      return static_cast<std::uint32_t>(pixel) / kTile * kTile;
    };
    flat.column0 = first(x0);
    flat.column1 = std::min(first(x1) + kTile, lattice_.width) - 1;
    flat.row0 = first(y0);
    flat.row1 = std::min(first(y1) + kTile, lattice_.height) - 1;
    return true;
  }

  void draw_pixel(const Bundle& bundle, std::size_t i, const Flat& flat, std::uint32_t column,
                  std::uint32_t row) {
    const float x = lattice_.x[column], y = lattice_.y[row];
    for (const Vec3f& edge : flat.edges) {
      if (!(at(edge, x, y) >= 0)) return;
    }
    const float now = at(flat.nearness, x, y);
    const std::size_t place = frame_.pixel_place(column, row);
    float& before = frame_.nearness[place];
    std::int32_t& seen = frame_.triangle[place];
    const std::int32_t number = bundle.triangle[i];
    if (!(now > before || (now == before && number < seen))) return;
    if (now > most_nearness_) return;
    const bool holes = (bundle.holes >> i & 1U) != 0;
    if (holes && !is_there(sight_.surfaces, eye_, static_cast<std::uint32_t>(number), x, y, now)) {
      return;
    }
    before = now;
    seen = number;
  }

  const RasterView& sight_;
  const Lattice& lattice_;
  const Eye& eye_;
  TileRows rows_;
  VisibilityBuffer& frame_;
  float most_nearness_;
};

}  // namespace

void rasterise_plainly(const RasterView& sight, TileRows rows, VisibilityBuffer& frame) {
  Drawer drawer(sight, rows, frame);
  for (const Bundle& bundle : sight.tree.bundles) {
    for (std::size_t i = 0; i < Bundle::kSize; ++i) drawer.draw(bundle, i);
  }
}

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
