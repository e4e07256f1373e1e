#include "enfilade/mesh/detail/exact_heights.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace enfilade::mesh::detail {
namespace {

constexpr float kUnknown = -std::numeric_limits<float>::infinity();

// The x between which a line of constant y is inside a triangle, seen from above. None if
// from > to.
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

// Finds the highest surface at the middle of each cell, triangle by triangle.
class Sweep {
 public:
  Sweep(const Lattice& lattice, double step, const Cells& floor)
      : lattice_(lattice), step_(step), floor_(floor), heights_(floor.cells.size(), kUnknown) {}

  void add(const std::array<Vec3d, 3>& t) {
    const double ux = t[1].x - t[0].x, uy = t[1].y - t[0].y;
    const double vx = t[2].x - t[0].x, vy = t[2].y - t[0].y;
    const double area = ux * vy - uy * vx;
    if (std::abs(area) < 1e-12) return;  // vertical, or a line or point
    const double uz = t[1].z - t[0].z, vz = t[2].z - t[0].z;
    const double dx = (uz * vy - vz * uy) / area, dy = (vz * ux - uz * vx) / area;
    const auto [south, north] = std::minmax({t[0].y, t[1].y, t[2].y});
    const Vec3f low = lattice_.box.low;
    const int last = last_place(north, low.y, lattice_.depth);
    for (int j = first_place(south, low.y); j <= last; ++j) {
      const double y = middle(low.y, j);
      const Crossing c = cross(t, y);
      if (c.from > c.to) continue;
      const int end = last_place(c.to, low.x, lattice_.width);
      for (int i = first_place(c.from, low.x); i <= end; ++i) {
        const double x = middle(low.x, i);
        meet(j * lattice_.width + i, t[0].z + dx * (x - t[0].x) + dy * (y - t[0].y));
      }
    }
  }

  float height(std::size_t cell) const { return heights_[cell]; }

 private:
  double middle(double low, int i) const { return low + (i + 0.5) * lattice_.cell; }
  // Triangles are widened by 1e-6 cells, so that a middle on a shared edge is in at least one.
  int first_place(double from, double low) const {
    return std::max(0, static_cast<int>(std::ceil((from - low) / lattice_.cell - 0.5 - 1e-6)));
  }
  int last_place(double to, double low, int count) const {
    return std::min(count - 1,
                    static_cast<int>(std::floor((to - low) / lattice_.cell - 0.5 + 1e-6)));
  }

  // A surface at height z at a column's middle, which counts for the cells that are close above it.
  void meet(int column, double z) {
    const auto at = static_cast<std::size_t>(column);
    for (std::size_t c = floor_.first_in_column[at]; c < floor_.first_in_column[at + 1]; ++c) {
      const double above = floor_.cells[c].position.z - z;  // of the cell, metres
      if (above < -lattice_.level || above > step_ + lattice_.level) continue;
      heights_[c] = std::max(heights_[c], static_cast<float>(z));
    }
  }

  const Lattice& lattice_;
  double step_;
  const Cells& floor_;
  std::vector<float> heights_;
};

}  // namespace

void set_exact_heights(const Mesh& mesh, const Lattice& lattice, double step, Cells& floor) {
  Sweep sweep(lattice, step, floor);
  for (const auto& triangle : mesh.triangles) {
    std::array<Vec3d, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) corners[i] = to_double(mesh.positions[triangle[i]]);
    sweep.add(corners);
  }
  for (std::size_t c = 0; c < floor.cells.size(); ++c) {
    const float exact = sweep.height(c);
    float& z = floor.cells[c].position.z;
    z = exact > kUnknown ? exact : z - static_cast<float>(lattice.level / 2);
  }
}

}  // namespace enfilade::mesh::detail
