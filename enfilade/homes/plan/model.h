/// \file  Parts of plans before they have doors: frames of corridors, strips, cells.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/homes/plan.h"

namespace enfilade::homes::plan {

inline constexpr double kInnerWall = 0.12, kOuterWall = 0.25;
inline constexpr double kFlightWidth = 1.0;
inline constexpr double kLanding = 1.05;  // before a flight's foot and behind its head

/// Walls' middle lines lie on a grid of 5 cm, so that walls of neighbours meet exactly.
inline double snap(double x) { return std::round(x * 20) / 20; }
inline double draw(Rng& rng, double low, double high) { return low + (high - low) * rng.uniform(); }
inline bool chance(Rng& rng, double share) { return rng.uniform() < share; }
inline bool is_one_of(char type, std::string_view types) {
  return types.find(type) != std::string_view::npos;
}

/// A part of the corridor; boxes here and below end at walls' middle lines.
struct Piece {
  Rect box;
  char type = 'h';
};
/// A strip beside the corridor, to be cut into rooms along it.
struct Block {
  Rect box;
  Side faces = Side::kPlusX;  // the side on which the corridor runs
  bool inner = false;         // between corridors: its rooms need no windows
};
struct Frame {
  std::vector<Piece> spine;
  std::vector<Block> blocks;
};
struct Flight {
  Rect box;  // true size
  Side towards = Side::kPlusX;
};
/// Corridors and strips of all storeys; the front is at y = 0.
struct Building {
  double width = 0, depth = 0;  // between the outer walls' middle lines
  std::vector<Frame> storeys;
  std::optional<Flight> flight;  // the same on all storeys
};

/// A room in the making.
struct Cell {
  Rect box;
  char type = '-';
  std::string name;
  bool spine = false;
  bool inner = false;               // meant to have no window
  double wanted = 0;                // m2
  std::optional<std::size_t> host;  // the cell that it is reached through; none: the corridor
  std::string hosts;                // types of cells that may be its host, if it needs one
};

/// The wall that two cells, or a cell and the outside, have in common.
struct SharedWall {
  bool along_x = true;
  double wall = 0, from = 0, to = 0;  // between middle lines of the walls that end it
  bool first_is_lower = true;
};
inline std::optional<SharedWall> shared_wall(const Rect& a, const Rect& b) {
  const double x0 = std::max(a.x0, b.x0), x1 = std::min(a.x1, b.x1);
  const double y0 = std::max(a.y0, b.y0), y1 = std::min(a.y1, b.y1);
  constexpr double kSame = 1e-6;
  if (std::abs(x1 - x0) < kSame && y1 - y0 > kSame)
    return SharedWall{false, x0, y0, y1, a.x0 < b.x0};
  if (std::abs(y1 - y0) < kSame && x1 - x0 > kSame)
    return SharedWall{true, y0, x0, x1, a.y0 < b.y0};
  return std::nullopt;
}
inline bool overlap(const Rect& a, const Rect& b) {
  constexpr double kTouch = 1e-6;
  return std::min(a.x1, b.x1) - std::max(a.x0, b.x0) > kTouch &&
         std::min(a.y1, b.y1) - std::max(a.y0, b.y0) > kTouch;
}
/// The same piece of wall on both sides of it, `reach` metres from its middle line.
inline Rect both_sides(bool along_x, double wall, double from, double to, double reach) {
  return laid_rect(along_x, from, to, wall - reach, wall + reach);
}

/// Whether a door or arch can be made between two cells at [from, to] of their wall. It needs
/// standing room before it, clear of the flight.
inline constexpr double kStand = 0.75;  // metres
inline bool clear_of_flight(const Rect& zone, const std::optional<Flight>& flight) {
  return !flight || !overlap(zone, flight->box);
}

/// The longest free piece for a door in the wall that two cells share: its length, 0 if none.
double door_room(const Rect& a, const Rect& b, const std::optional<Flight>& flight);

}  // namespace enfilade::homes::plan
