#include "enfilade/mesh/walkable.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "enfilade/mesh/detail/floor_field.h"

namespace enfilade::mesh {

using namespace detail;

namespace {

constexpr double kAboveFloor = 0.05;  // points this far below the floor are still on it

FloorCells gather(const FloorField& field, const FloorLattice& lattice,
                  const WalkableOptions& options) {
  const std::vector<std::uint32_t> ranks = rank_spans(field, options);
  FloorCells out;
  out.first_in_column.assign(static_cast<std::size_t>(lattice.width * lattice.depth) + 1, 0);
  std::vector<std::uint32_t> place(field.spans(), kNoSpan);
  for (std::uint32_t s = 0; s < field.spans(); ++s) {
    if (ranks[s] == kNoSpan) continue;
    place[s] = static_cast<std::uint32_t>(out.cells.size());
    out.cells.push_back(field.cell(s));
    out.cells.back().area = ranks[s];
    ++out.first_in_column[static_cast<std::size_t>(field.column(s)) + 1];
  }
  std::partial_sum(out.first_in_column.begin(), out.first_in_column.end(),
                   out.first_in_column.begin());
  out.first_link.push_back(0);
  for (std::uint32_t s = 0; s < field.spans(); ++s) {
    if (place[s] == kNoSpan) continue;
    field.each_neighbour(s, [&](std::uint32_t next) { out.links.push_back(place[next]); });
    out.first_link.push_back(static_cast<std::uint32_t>(out.links.size()));
  }
  return out;
}

constexpr float kUnknown = -std::numeric_limits<float>::infinity();

// The x between which a line of constant y is inside a triangle, seen from above. None if
// from > to.
struct Crossing {
  double from = std::numeric_limits<double>::infinity(), to = -from;
};

Crossing cross_triangle(const std::array<Vec3d, 3>& t, double y) {
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
  Sweep(const FloorLattice& lattice, double step, const FloorCells& floor)
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
      const Crossing c = cross_triangle(t, y);
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

  const FloorLattice& lattice_;
  double step_;
  const FloorCells& floor_;
  std::vector<float> heights_;
};

/// Moves each cell to the highest surface at its centre that is near its height. Recast's cells
/// have the height of the highest surface anywhere in them, such as the next stair. If there is no
/// surface (a crack between triangles), the cell is lowered by half a level, the mean error.
/// \param step how far a cell may lie above the surface at its middle
void set_exact_heights(const Mesh& mesh, const FloorLattice& lattice, double step,
                       FloorCells& floor) {
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

}  // namespace

WalkableFloor::WalkableFloor(const Mesh& mesh, const WalkableOptions& options) : options_(options) {
  check_walkable_input(mesh, options);
  lattice_ = make_lattice(mesh, options);
  if (options.growing_cell) {
    options_.cell = fitting_cell(mesh, options);
    lattice_ = make_lattice(mesh, options_);
  }
  FloorField field = make_field(mesh, options_, lattice_);
  field.erode(options_);
  field.measure_distances();
  floor_ = gather(field, lattice_, options_);
  set_exact_heights(mesh, lattice_, options.body.step, floor_);
  for (const FloorCell& cell : floor_.cells) areas_ = std::max<std::size_t>(areas_, cell.area + 1);
}

std::span<const std::uint32_t> WalkableFloor::neighbours(std::size_t cell) const noexcept {
  const std::uint32_t first = floor_.first_link[cell];
  return std::span(floor_.links).subspan(first, floor_.first_link[cell + 1] - first);
}

double WalkableFloor::area_m2() const noexcept {
  return static_cast<double>(cells().size()) * options_.cell * options_.cell;
}

std::optional<std::size_t> WalkableFloor::below(Vec3f point, double drop) const {
  const double x = std::floor((point.x - lattice_.box.low.x) / lattice_.cell);
  const double y = std::floor((point.y - lattice_.box.low.y) / lattice_.cell);
  if (!(x >= 0 && x < lattice_.width && y >= 0 && y < lattice_.depth)) return std::nullopt;
  const auto column = static_cast<std::size_t>(y * lattice_.width + x);
  for (std::size_t c = floor_.first_in_column[column + 1]; c > floor_.first_in_column[column];
       --c) {
    const double down = static_cast<double>(point.z) - floor_.cells[c - 1].position.z;
    if (down >= -kAboveFloor) return down <= drop ? std::optional(c - 1) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace enfilade::mesh
