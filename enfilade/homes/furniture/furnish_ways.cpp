#include <algorithm>
#include <cmath>
#include <cstdint>

#include "enfilade/homes/furniture/furnish_room.h"

namespace enfilade::homes::furniture {
namespace {

constexpr double kCell = 0.08;

/// The floor as a grid of cells: those where the middle of a body with some radius can be.
class FloorGrid {
 public:
  FloorGrid(const Rect& floor, double radius)
      : floor_(floor),
        radius_(radius),
        nx_(std::max<std::size_t>(1, static_cast<std::size_t>(floor.width() / kCell))),
        ny_(std::max<std::size_t>(1, static_cast<std::size_t>(floor.depth() / kCell))),
        free_(nx_ * ny_, 1) {
    for (std::size_t i = 0; i < free_.size(); ++i) {
      const double x = x_of(i), y = y_of(i);
      const double edge = std::min({x - floor.x0, floor.x1 - x, y - floor.y0, floor.y1 - y});
      if (edge < radius_) free_[i] = 0;
    }
  }

  void block(const Rect& r) {
    const auto from = [](double v) { return static_cast<std::size_t>(std::max(0.0, v)); };
    const std::size_t i0 = from((r.x0 - radius_ - floor_.x0) / kCell - 1);
    const std::size_t i1 = std::min(nx_, from((r.x1 + radius_ - floor_.x0) / kCell + 1));
    const std::size_t k0 = from((r.y0 - radius_ - floor_.y0) / kCell - 1);
    const std::size_t k1 = std::min(ny_, from((r.y1 + radius_ - floor_.y0) / kCell + 1));
    for (std::size_t k = k0; k < k1; ++k) {
      for (std::size_t i = i0; i < i1; ++i) {
        const std::size_t cell = k * nx_ + i;
        const double dx = std::max({r.x0 - x_of(cell), x_of(cell) - r.x1, 0.0});
        const double dy = std::max({r.y0 - y_of(cell), y_of(cell) - r.y1, 0.0});
        if (dx * dx + dy * dy < radius_ * radius_) free_[cell] = 0;
      }
    }
  }

  /// The free cell nearest to a point, at most `reach` away.
  std::optional<std::size_t> nearest(double x, double y, double reach) const {
    std::optional<std::size_t> best;
    double nearest = reach * reach;
    for (std::size_t i = 0; i < free_.size(); ++i) {
      if (free_[i] == 0) continue;
      const double dx = x_of(i) - x, dy = y_of(i) - y;
      if (dx * dx + dy * dy > nearest) continue;
      nearest = dx * dx + dy * dy;
      best = i;
    }
    return best;
  }

  std::vector<std::uint8_t> reached_from(std::size_t start) const {
    std::vector<std::uint8_t> seen(free_.size(), 0);
    std::vector<std::size_t> open{start};
    seen[start] = 1;
    while (!open.empty()) {
      const std::size_t cell = open.back();
      open.pop_back();
      const std::size_t i = cell % nx_, k = cell / nx_;
      const auto visit = [&](std::size_t next) {
        if (free_[next] == 0 || seen[next] != 0) return;
        seen[next] = 1;
        open.push_back(next);
      };
      if (i > 0) visit(cell - 1);
      if (i + 1 < nx_) visit(cell + 1);
      if (k > 0) visit(cell - nx_);
      if (k + 1 < ny_) visit(cell + nx_);
    }
    return seen;
  }

  double distance(std::size_t cell, double x, double y) const {
    const double dx = x_of(cell) - x, dy = y_of(cell) - y;
    return std::sqrt(dx * dx + dy * dy);
  }
  const std::vector<std::uint8_t>& free() const { return free_; }

 private:
  double x_of(std::size_t cell) const {
    return floor_.x0 + (double(cell % nx_) + 0.5) * floor_.width() / double(nx_);
  }
  double y_of(std::size_t cell) const {
    return floor_.y0 + (double(cell / nx_) + 0.5) * floor_.depth() / double(ny_);
  }

  Rect floor_;
  double radius_;
  std::size_t nx_, ny_;
  std::vector<std::uint8_t> free_;
};

/// The free cell nearest to the point `deep` metres inside a door, at most `reach` from it.
std::optional<std::size_t> cell_inside(const looks::RoomSpace& space, const FloorGrid& grid,
                                       const looks::RoomSpace::WallHole& door, double deep,
                                       double reach) {
  const double n = space.floor.at(door.wall) + (is_high(door.wall) ? -deep : deep);
  return runs_along_x(door.wall) ? grid.nearest(door.middle(), n, reach)
                                 : grid.nearest(n, door.middle(), reach);
}

bool connected(const looks::RoomSpace& space, const FloorGrid& grid, double radius) {
  const Rect& f = space.floor;
  const double mx = (f.x0 + f.x1) / 2, my = (f.y0 + f.y1) / 2;
  std::optional<std::size_t> first;
  std::vector<std::uint8_t> reached;
  for (const auto& hole : space.holes) {
    if (!hole.is_door()) continue;
    const auto cell = cell_inside(space, grid, hole, radius + kCell, 2.5 * kCell);
    if (!cell) return false;
    if (!first) {
      first = cell;
      reached = grid.reached_from(*cell);
    } else if (reached[*cell] == 0) {
      return false;
    }
  }
  if (!first) return true;
  // A table may stand in the middle itself: a place beside it is enough.
  const double near = std::max(0.9, 0.55 * std::min(f.width(), f.depth()));
  for (std::size_t i = 0; i < reached.size(); ++i) {
    if (reached[i] != 0 && grid.distance(i, mx, my) <= near) return true;
  }
  return false;
}

/// The area of free floor, m2, that cannot be reached from the first door.
double cut_off(const looks::RoomSpace& space, const FloorGrid& grid, double radius) {
  for (const auto& hole : space.holes) {
    if (!hole.is_door()) continue;
    const auto cell = cell_inside(space, grid, hole, radius + kCell, 3 * kCell);
    if (!cell) continue;
    const auto reached = grid.reached_from(*cell);
    std::size_t lost = 0;
    for (std::size_t i = 0; i < reached.size(); ++i) {
      if (grid.free()[i] != 0 && reached[i] == 0) ++lost;
    }
    return double(lost) * kCell * kCell;
  }
  return 0;
}

}  // namespace

bool ways_are_open(const looks::RoomSpace& space, const std::vector<Rect>& standing) {
  constexpr double kHalfWay = 0.375, kBody = 0.25, kLeastPocket = 0.5;
  const double half = std::min(space.floor.width(), space.floor.depth()) / 2;
  const double way = std::min(kHalfWay, half - 0.8 * kCell), body = std::min(kBody, way);
  if (way <= 0) return standing.empty();
  FloorGrid wide(space.floor, way), narrow(space.floor, body);
  for (const auto* blocked : {&standing, &space.no_way}) {
    for (const Rect& r : *blocked) {
      wide.block(r);
      narrow.block(r);
    }
  }
  return connected(space, wide, way) && cut_off(space, narrow, body) <= kLeastPocket;
}

}  // namespace enfilade::homes::furniture
