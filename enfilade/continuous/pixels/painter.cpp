#include "enfilade/continuous/pixels/painter.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <span>

#include "enfilade/image/image.h"
#include "enfilade/render/renderer.h"

namespace enfilade::continuous::pixels {
namespace {

Vec3f times(Vec3f a, Vec3f b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }

template <class T>
T* values_at(std::span<std::byte> pixels, std::size_t first) {
  return reinterpret_cast<T*>(pixels.data()) + first;
}

}  // namespace

Sphere::Sphere(std::uint32_t across, std::uint32_t down)
    : width(across), height(down), column(across), level(down), up(down) {
  for (std::uint32_t j = 0; j < width; ++j) {
    const double turned = ((j + 0.5) / width - 0.5) * 2 * kPi;
    column[j] = to_float({std::sin(turned), std::cos(turned), 0});
  }
  for (std::uint32_t i = 0; i < height; ++i) {
    const double elevation = (0.5 - (i + 0.5) / height) * kPi;
    level[i] = static_cast<float>(std::cos(elevation));
    up[i] = static_cast<float>(std::sin(elevation));
  }
}

void PixelPainter::trace(TileRows rows, const DepthRange& range, VisibilityBuffer& frame) const {
  const std::uint32_t width = pixels_.width(), height = pixels_.height();
  std::array<mesh::Ray, kTilePixels> rays;
  std::array<mesh::Hit, kTilePixels> hits;
  std::array<std::size_t, kTilePixels> places;
  for (std::uint32_t y0 = rows.begin * kTile; y0 < std::min(rows.end * kTile, height);
       y0 += kTile) {
    for (std::uint32_t x0 = 0; x0 < width; x0 += kTile) {
      std::size_t n = 0;
      for (const auto [dx, dy] : mesh::kZOrder) {
        const std::uint32_t x = x0 + dx, y = y0 + dy;
        if (x >= width || y >= height) continue;
        places[n] = frame.pixel_place(x, y);
        rays[n++] = {eye_.whole, pixels_.towards(eye_, x, y), range.near, range.far};
      }
      scene_.tracer->trace(std::span(rays).first(n), std::span(hits).first(n));
      if (n < kTilePixels) {
        // What lies beyond the picture's edge may be left from another building.
        const std::size_t first = frame.tile_place(x0 / kTile, y0 / kTile) * kTilePixels;
        std::fill_n(frame.triangle.begin() + static_cast<std::ptrdiff_t>(first), kTilePixels,
                    kNothing);
        std::fill_n(frame.nearness.begin() + static_cast<std::ptrdiff_t>(first), kTilePixels,
                    kLeastNearness);
      }
      for (std::size_t i = 0; i < n; ++i) {
        frame.triangle[places[i]] =
            hits[i] ? static_cast<std::int32_t>(hits[i].triangle) : kNothing;
        frame.nearness[places[i]] = hits[i] ? 1 / hits[i].distance : kLeastNearness;
      }
    }
  }
}

Vec3f PixelPainter::sky(Vec3f towards) const {
  if (!scene_.lit) return {};
  return mesh::sky_radiance(scene_.sky, (1 / length(towards)) * towards);
}

// Texels from a pixel to the next one on the surface, right or down, whichever is farther, for a
// picture of spread 1 at distance 1.
inline float PixelPainter::longer_step(const Surface& surface, Vec3f towards, float across) const {
  const auto square = [&](Vec3f axis) {
    const Vec3f step = axis - (dot(axis, surface.normal) / across) * towards;
    const float s = dot(surface.along_s, step), t = dot(surface.along_t, step);
    return s * s + t * t;
  };
  return std::sqrt(std::max(square(eye_.right), square(eye_.down)));
}

inline Vec3f PixelPainter::look(const Surface& surface, const Paint& paint, Vec3f from,
                                Vec3f towards, float distance) const {
  const Weights at = weights_at(surface, from);
  const float across = dot(towards, surface.normal);
  const Vec3f light = light_at(scene_.surfaces.light.data(), surface,
                               across > 0 ? surface.back : surface.front, at);
  Vec3f colour = paint.colour;
  if (paint.texture != Paint::kNoTexture) {
    float texels = 0;
    if (takes_longer_step()) {
      texels = pixels_.spread * distance * longer_step(surface, towards, across);
    } else {
      // Seen at a slant, a texel covers fewer pixels along one axis: the mean of both axes.
      const float size = length(towards);
      const float slant = std::sqrt(std::max(std::abs(across) / size, kLeastSlant));
      texels = pixels_.spread * distance * size / slant * surface.texels_per_metre;
    }
    const Filtered texel = scene_.surfaces.textures.at(
        paint.texture, surface.s0 + at.u * surface.su + at.v * surface.sv,
        surface.t0 + at.u * surface.tu + at.v * surface.tv, texels);
    colour = times(colour, {scene_.linear.of(texel.parts[0]), scene_.linear.of(texel.parts[1]),
                            scene_.linear.of(texel.parts[2])});
  }
  colour += {paint.gloss, paint.gloss, paint.gloss};
  return times(colour, light) + paint.emission;
}

// One reflection; a mirror in a mirror is as bright as a white wall there.
Vec3f PixelPainter::mirrored(const Surface& surface, const Paint& paint, Vec3f from, Vec3f towards,
                             Vec3f light) const {
  const float across = dot(towards, surface.normal);
  const Vec3f back = towards - 2 * across * surface.normal;
  const Vec3f at = surface.origin + from;
  const float far = std::max({std::abs(at.x), std::abs(at.y), std::abs(at.z)});
  const float lift = (across > 0 ? -1.0F : 1.0F) * (3e-4F + 1e-6F * far);
  const mesh::Ray ray{at + lift * surface.normal, back};
  const mesh::Hit hit = scene_.tracer->trace(ray);
  Vec3f seen;
  if (!hit) {
    seen = sky(back);
  } else {
    const Surface& other = scene_.surfaces.all[hit.triangle];
    const Paint& its = scene_.surfaces.paints[other.paint];
    const Vec3f there = (ray.origin - other.origin) + hit.distance * back;
    seen = look(other, its, there, back, hit.distance);
    if (its.mirror > 0) {
      const std::uint32_t side = dot(back, other.normal) > 0 ? other.back : other.front;
      seen += its.mirror *
              light_at(scene_.surfaces.light.data(), other, side, weights_at(other, there));
    }
  }
  return light + paint.mirror * seen;
}

void PixelPainter::find_directions(std::uint32_t tile_x, std::uint32_t tile_y,
                                   Directions& out) const {
  if (pixels_.lattice != nullptr) return find_directions(*pixels_.lattice, tile_x, tile_y, out);
  for (std::uint32_t k = 0; k < kTilePixels; ++k) {
    const std::uint32_t column = std::min(tile_x * kTile + k % kTile, pixels_.width() - 1);
    const std::uint32_t row = std::min(tile_y * kTile + k / kTile, pixels_.height() - 1);
    const Vec3f towards = pixels_.towards(eye_, column, row);
    out.x[k] = towards.x;
    out.y[k] = towards.y;
    out.z[k] = towards.z;
  }
}

// As Pixels::towards(), with the products of rows and columns taken once.
void PixelPainter::find_directions(const Lattice& lattice, std::uint32_t tile_x,
                                   std::uint32_t tile_y, Directions& out) const {
  std::array<Vec3f, kTile> across;
  for (std::uint32_t i = 0; i < kTile; ++i) across[i] = lattice.x[tile_x * kTile + i] * eye_.right;
  for (std::uint32_t k = 0, row = tile_y * kTile; k < kTilePixels; ++row) {
    const Vec3f down = lattice.y[row] * eye_.down;
    for (std::uint32_t i = 0; i < kTile; ++i, ++k) {
      const Vec3f towards = across[i] + down + eye_.forward;
      out.x[k] = towards.x;
      out.y[k] = towards.y;
      out.z[k] = towards.z;
    }
  }
}

void PixelPainter::colour(const TileColours& tile,
                          std::array<std::uint32_t, kTilePixels>& rgba) const {
  std::uint64_t wanted = ~std::uint64_t{0};
  if (!photos_.empty()) wanted = colouring_.reprojector(tile, photos_, rgba.data());
  if (wanted == 0) return;
  std::array<std::uint32_t, kTilePixels> of_mesh;
  std::uint64_t left = ~std::uint64_t{0};
  if (colouring_.shader != nullptr) left = colouring_.shader(tile, of_mesh.data());
  for (; wanted != 0; wanted &= wanted - 1) {
    const auto k = static_cast<std::size_t>(std::countr_zero(wanted));
    if ((left >> k & 1U) == 0) {
      rgba[k] = of_mesh[k];
      continue;
    }
    const Vec3f towards{tile.towards.x[k], tile.towards.y[k], tile.towards.z[k]};
    rgba[k] = scene_.tone.rgba(look(tile.triangle[k], towards, 1 / tile.nearness[k]));
  }
}

void PixelPainter::colour_tiles(const VisibilityBuffer& frame, std::uint32_t tile_y,
                                std::vector<std::uint32_t>& lines) const {
  const std::uint32_t pitch = line_pitch(pixels_.width());
  Directions directions;
  std::array<std::uint32_t, kTilePixels> rgba;
  for (std::uint32_t tile_x = 0; tile_x < pitch / kTile; ++tile_x) {
    find_directions(tile_x, tile_y, directions);
    const std::size_t first = frame.tile_place(tile_x, tile_y) * kTilePixels;
    const TileColours tile{scene_,
                           eye_,
                           pixels_.spread,
                           frame.triangle.data() + first,
                           frame.nearness.data() + first,
                           directions,
                           takes_longer_step()};
    colour(tile, rgba);
    for (std::size_t y = 0; y < kTile; ++y) {
      std::copy_n(rgba.begin() + static_cast<std::ptrdiff_t>(y * kTile), kTile,
                  lines.begin() + static_cast<std::ptrdiff_t>(y * pitch + tile_x * kTile));
    }
  }
}

void PixelPainter::paint_depth(const VisibilityBuffer& frame, std::uint32_t row,
                               const render::DepthOutput& output, std::size_t first) const {
  const bool along_ray = pixels_.lattice != nullptr && output.measure == render::DepthMeasure::kRay;
  const auto each = [&](const auto& put) {
    for (std::uint32_t j0 = 0; j0 < pixels_.width(); j0 += kTile) {
      const std::size_t place = frame.pixel_place(j0, row);
      const std::uint32_t columns = std::min(kTile, pixels_.width() - j0);
      for (std::uint32_t i = 0; i < columns; ++i) {
        float metres = frame.triangle[place + i] < 0 ? 0.0F : 1 / frame.nearness[place + i];
        if (along_ray) metres = metres * length(pixels_.towards(eye_, j0 + i, row));
        put(j0 + i, metres);
      }
    }
  };
  if (output.format == render::DepthFormat::kMetresFloat32) {
    float* const out = values_at<float>(output.pixels, first);
    return each([out](std::uint32_t j, float metres) { out[j] = metres; });
  }
  auto* const out = values_at<std::uint16_t>(output.pixels, first);
  each([out](std::uint32_t j, float metres) {
    out[j] = metres > 0 ? image::depth_units(metres) : std::uint16_t{0};
  });
}

void PixelPainter::paint(const VisibilityBuffer& frame, TileRows rows,
                         const render::Outputs& outputs, std::size_t view,
                         std::vector<std::uint32_t>& lines) const {
  const std::uint32_t width = pixels_.width();
  const std::size_t pixels = std::size_t{width} * pixels_.height();
  for (std::uint32_t row = rows.begin * kTile; row < std::min(rows.end * kTile, pixels_.height());
       ++row) {
    const std::size_t in_view = std::size_t{row} * width, first = view * pixels + in_view;
    if (outputs.colour) {
      if (row % kTile == 0) colour_tiles(frame, row / kTile, lines);
      const std::size_t begin = std::size_t{row % kTile} * line_pitch(width);
      render::pack_colours(*outputs.colour, {view, in_view, pixels},
                           std::span(lines).subspan(begin, width));
    }
    if (outputs.depth) paint_depth(frame, row, *outputs.depth, first);
    const auto surface = [&](std::uint32_t j) -> const Surface* {
      const std::int32_t triangle = frame.triangle[frame.pixel_place(j, row)];
      return triangle < 0 ? nullptr : &scene_.surfaces.all[static_cast<std::size_t>(triangle)];
    };
    if (outputs.classes) {
      const bool bytes = outputs.classes->format == render::ClassFormat::kUint8;
      for (std::uint32_t j = 0; j < width; ++j) {
        const Surface* const s = surface(j);
        const std::uint16_t category = s == nullptr ? std::uint16_t{0} : s->category;
        if (bytes) {
          *values_at<std::uint8_t>(outputs.classes->pixels, first + j) =
              static_cast<std::uint8_t>(std::min<std::uint16_t>(category, 255));
        } else {
          *values_at<std::uint16_t>(outputs.classes->pixels, first + j) = category;
        }
      }
    }
    if (outputs.instances) {
      for (std::uint32_t j = 0; j < width; ++j) {
        const Surface* const s = surface(j);
        outputs.instances->pixels[first + j] = s == nullptr ? 0 : s->instance;
      }
    }
  }
}

}  // namespace enfilade::continuous::pixels
