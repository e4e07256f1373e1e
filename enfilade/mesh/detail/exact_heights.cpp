#include "enfilade/mesh/detail/exact_heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

namespace enfilade::mesh::detail {
namespace {

constexpr float kUnknown = -std::numeric_limits<float>::infinity();

// Where a horizontal line of middles runs through a triangle, seen from above.
struct Crossing {
  double from = std::numeric_limits<double>::infinity(), to = -from;
};

Crossing cross(const std::array<Vec3d, 3>& t, double y) {
  Crossing c;
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3d a = t[i], b = t[(i + 1) % 3];
    if ((a.y < y && b.y < y) || (a.y > y && b.y > y)) continue;
    const double share = a.y == b.y ? 0 : (y - a.y) / (b.y - a.y);
    const double x = a.x + share * (b.x - a.x);
    c.from = std::min(c.from, x);
    c.to = std::max(c.to, x);
  }
  return c;
}

class Sweep {
 public:
  Sweep(const Columns& columns, std::span<const FloorCell> cells)
      : columns_(columns), cells_(cells), heights_(cells.size(), kUnknown) {}

  void add(const std::array<Vec3d, 3>& t) {
    const double ux = t[1].x - t[0].x, uy = t[1].y - t[0].y;
    const double vx = t[2].x - t[0].x, vy = t[2].y - t[0].y;
    const double area = ux * vy - uy * vx;
    if (std::abs(area) < 1e-12) return;  // upright, or nothing
    const double uz = t[1].z - t[0].z, vz = t[2].z - t[0].z;
    const double dx = (uz * vy - vz * uy) / area, dy = (vz * ux - uz * vx) / area;
    const auto [south, north] = std::minmax({t[0].y, t[1].y, t[2].y});
    const int last = last_place(north, columns_.south, columns_.depth);
    for (int j = first_place(south, columns_.south); j <= last; ++j) {
      const double y = middle(columns_.south, j);
      const Crossing c = cross(t, y);
      if (c.from > c.to) continue;
      const int end = last_place(c.to, columns_.west, columns_.width);
      for (int i = first_place(c.from, columns_.west); i <= end; ++i) {
        const double x = middle(columns_.west, i);
        meet(j * columns_.width + i, t[0].z + dx * (x - t[0].x) + dy * (y - t[0].y));
      }
    }
  }

  float height(std::size_t cell) const { return heights_[cell]; }

 private:
  double middle(double low, int i) const { return low + (i + 0.5) * columns_.cell; }
  // A hair is added so that middles on a shared edge are in one triangle at least.
  int first_place(double from, double low) const {
    return std::max(0, static_cast<int>(std::ceil((from - low) / columns_.cell - 0.5 - 1e-6)));
  }
  int last_place(double to, double low, int count) const {
    return std::min(count - 1,
                    static_cast<int>(std::floor((to - low) / columns_.cell - 0.5 + 1e-6)));
  }

  void meet(int column, double z) {
    const auto at = static_cast<std::size_t>(column);
    for (std::size_t c = columns_.first[at]; c < columns_.first[at + 1]; ++c) {
      const double above = cells_[c].position.z - z;
      if (above < -columns_.level || above > columns_.step + columns_.level) continue;
      heights_[c] = std::max(heights_[c], static_cast<float>(z));
    }
  }

  const Columns& columns_;
  std::span<const FloorCell> cells_;
  std::vector<float> heights_;
};

}  // namespace

void set_exact_heights(const Mesh& mesh, const Columns& columns, std::span<FloorCell> cells) {
  Sweep sweep(columns, cells);
  for (const auto& triangle : mesh.triangles) {
    std::array<Vec3d, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) corners[i] = to_double(mesh.positions[triangle[i]]);
    sweep.add(corners);
  }
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const float z = sweep.height(c);
    cells[c].position.z =
        z > kUnknown ? z : cells[c].position.z - static_cast<float>(columns.level / 2);
  }
}

}  // namespace enfilade::mesh::detail
