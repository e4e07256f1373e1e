#include <algorithm>
#include <array>
#include <cmath>

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
  Drawer(const Sight& sight, TileRows rows, Frame& frame)
      : sight_(sight), lattice_(sight.lattice), eye_(sight.eye), rows_(rows), frame_(frame) {}

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
    if (!(std::abs(volume) > 0)) return false;
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
    const bool holes = (bundle.holes >> i & 1U) != 0;
    if (holes && !is_there(sight_.surfaces, eye_, static_cast<std::uint32_t>(number), x, y, now)) {
      return;
    }
    before = now;
    seen = number;
  }

  const Sight& sight_;
  const Lattice& lattice_;
  const Eye& eye_;
  TileRows rows_;
  Frame& frame_;
};

}  // namespace

void rasterise_plainly(const Sight& sight, TileRows rows, Frame& frame) {
  Drawer drawer(sight, rows, frame);
  for (const Bundle& bundle : sight.tree.bundles) {
    for (std::size_t i = 0; i < Bundle::kSize; ++i) drawer.draw(bundle, i);
  }
}

}  // namespace enfilade::continuous::pixels
