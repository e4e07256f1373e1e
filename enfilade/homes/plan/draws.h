/// \file  The steps in which a plan is drawn: rooms that are wanted, corridors, layout, openings,
/// check.
#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
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
struct CorridorPiece {
  Rect box;
  char type = 'h';
};
/// A strip beside the corridor, to be cut into rooms along it.
struct RoomStrip {
  Rect box;
  Side faces = Side::kPlusX;  // the side on which the corridor runs
  bool inner = false;         // between corridors: its rooms need no windows
};
struct StoreyFrame {
  std::vector<CorridorPiece> spine;
  std::vector<RoomStrip> blocks;
};
struct Flight {
  Rect box;  // true size
  Side towards = Side::kPlusX;
};
/// Corridors and strips of all storeys; the front is at y = 0.
struct BuildingFrame {
  double width = 0, depth = 0;  // between the outer walls' middle lines
  std::vector<StoreyFrame> storeys;
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

/// Cells are the plan's rooms, in the same order; `middle` is the outline between the outer walls'
/// middle lines; the front is its side `front`.
struct Sketch {
  std::vector<Cell> cells;
  std::optional<Flight> flight;
  Rect middle;
  Side front = Side::kMinusY;
};

/// \pre plan has rooms and no openings. False if a door found no place.
bool add_openings(const Sketch& sketch, Plan& plan, Rng& rng);

/// The floor in front of an opening (kStand deep) on both sides, and what its open leaf covers.
Rect opening_zone(const Plan& plan, const Opening& opening);
std::optional<Rect> leaf_zone(const Plan& plan, const Opening& opening);
double wall_thickness(const Plan& plan, const Opening& opening);

/// The usual sizes of a room type.
struct RoomSize {
  char type = '-';
  double least = 0, usual = 0, most = 0;  // m2
  double least_side = 0;                  // metres, between middle lines
};
const RoomSize& room_size(char type);

/// A piece of a strip that is decided on as a whole.
struct ChainItem {
  enum class Form : std::uint8_t {
    kRoom,       // the strip's whole depth
    kPair,       // one room at the corridor, another behind it, reached from a neighbour
    kSuite,      // a bedroom, and beside it a pair that is reached from it
    kHotelRoom,  // a bath and a small hall at the corridor, the bedroom behind
  };
  Form shape = Form::kRoom;
  char type = 'z', near = 'z', far = 'z';  // `type`: of a kRoom or the bedroom
  std::string name = {}, near_name = {}, far_name = {};
  std::string far_hosts = {};  // kPair: types through which the far room is reached
  double area = 0;             // wanted, m2, of all of it
};

/// Rooms that are laid side by side, in this order, as far as the strips allow.
struct Chain {
  std::vector<ChainItem> items;
  bool inner = false;  // for strips without windows
};

struct ProgramNeeds {
  HomeKind kind = HomeKind::kHouse;
  unsigned storey = 0, storeys = 1;
  double strips = 60;  // m2 to be filled, with windows
  double inner = 0;    // m2 to be filled, without
  double depth = 4;    // metres, of the deepest strip
};
std::vector<Chain> draw_program(const ProgramNeeds& needs, Rng& rng);

struct FrameNeeds {
  HomeKind kind = HomeKind::kHouse;
  unsigned storeys = 1;
  double area = 100;  // m2 of one storey
  double run = 4.2;   // metres that a flight of stairs takes
};

/// One of several skeletons: hall through the middle, corridor across, L, U, comb. Its proportions
/// are drawn; no value if the draw does not fit the area.
std::optional<BuildingFrame> draw_building(const FrameNeeds& needs, Rng& rng);

struct StoreyLayout {
  std::vector<Cell> cells;  // the corridor's pieces first
  double score = 0;         // higher is better
};

/// The best of `trials` random orders of the program's rooms; no value if there is none. In it each
/// room fits, has windows if it needs them and is reached without passing private rooms.
std::optional<StoreyLayout> fill(const BuildingFrame& building, unsigned storey,
                                 const std::vector<Chain>& program, unsigned trials, Rng& rng);

/// Faults of a plan, in words; none if it is sound:
/// - rooms within the outline, apart from each other, of fair size
/// - openings in walls of both rooms, clear of corners, each other and flights
/// - all rooms connected as make_plan() promises
/// - windows where people stay
/// - stairs with landings
std::vector<std::string> plan_faults(const Plan& plan);

inline constexpr double kLeastWithStairs = 85;  ///< m2 of each storey of a home with stairs

/// As homes::make_plan(), with a limit of its own on the number of draws.
Plan make_plan(const PlanOptions& options, unsigned most_draws);

}  // namespace enfilade::homes::plan
