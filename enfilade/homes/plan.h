/// \file  The plan of a made-up building: storeys, rooms, walls, doors, windows, stairs.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/geometry/rect.h"

namespace enfilade::homes {

/// Kind of a building.
enum class HomeKind : std::uint8_t { kHouse, kFlat, kOffice, kHotelFloor };
/// Their names: core/enum_names.h.
constexpr std::array<std::string_view, 4> names_of(HomeKind /*enum*/) {
  return {"house", "flat", "office", "hotel"};
}

/// Requirements of a plan; the rest is drawn from the seed.
struct PlanOptions {
  std::uint64_t seed = 1;
  std::optional<HomeKind> kind;     ///< none: drawn
  std::optional<unsigned> storeys;  ///< 1 .. 3 (flats and hotel floors have 1); none: drawn
  /// m2 of all storeys, 60 .. 3000 and, with stairs, 85 or more a storey; 0: drawn
  double area = 0;
};

/// Limits of PlanOptions::area, m2 of all storeys.
inline constexpr double kLeastArea = 60;
inline constexpr double kMostArea = 3000;

/// No plan was found for options that are in range; what() names them.
class NoPlan : public Error {
 public:
  using Error::Error;
};

/// A room of a plan. The style of its surfaces is chosen later, from the type.
struct PlanRoom {
  char type = '-';   ///< Matterport3D's region letter: 'b' bedroom, 'h' hallway, 's' stairs, ...
  std::string name;  ///< as people call it: "master bedroom", "kitchen"; types may repeat
  unsigned storey = 0;
  Rect floor;            ///< inner faces of its walls
  double ceiling = 2.6;  ///< metres above the storey's floor
};

/// Content of a hole in a wall.
enum class OpeningKind : std::uint8_t {
  kDoor,      ///< with a frame; its leaf stands open at Opening::leaf degrees
  kArch,      ///< a wide opening without a door
  kWindow,    ///< glass; to the outside
  kEntrance,  ///< the front door, closed
};
/// A hole in a wall.
struct Opening {
  OpeningKind kind = OpeningKind::kDoor;
  std::size_t room0 = 0;             ///< the room on its lower-coordinate side, or the only one
  std::optional<std::size_t> room1;  ///< none: outside
  bool along_x = true;               ///< the wall runs along x (else along y)
  double wall = 0;                   ///< y (x) of the wall's middle line
  double from = 0, to = 0;           ///< x (y) of its sides
  double sill = 0, head = 2.1;       ///< metres above the storey's floor
  bool leaf_in_room1 = false, hinge_at_to = false;
  double leaf = 0;  ///< degrees that the door stands open; 0: no leaf at all
};

/// A straight flight of stairs. On both storeys it lies inside a room of type 's'.
struct Stairs {
  unsigned storey = 0;  ///< the lower one
  std::size_t room_below = 0, room_above = 0;
  Rect flight;  ///< in plan
  Side climbs_towards = Side::kPlusX;
  unsigned steps = 16;
};

/// A floor of the building, by its heights.
struct PlanStorey {
  double floor = 0;   ///< world z, metres
  double height = 3;  ///< to the next storey's floor
};

/// All of a building's plan. World frame: metres, +z up.
struct Plan {
  HomeKind kind = HomeKind::kHouse;
  std::uint64_t seed = 0;
  std::vector<PlanStorey> storeys;
  std::vector<PlanRoom> rooms;
  std::vector<Opening> openings;
  std::vector<Stairs> stairs;
  double inner_wall = 0.12, outer_wall = 0.25;  ///< thickness, metres
  Rect outline;                                 ///< outer faces
};

/// \throws ArgumentError for options out of range
void check_options(const PlanOptions& options);

/// Draws a plan. The front door leads to a hall. Living room, dining room and kitchen are
/// neighbours, sometimes without doors between them. Bedrooms and baths lie along corridors;
/// offices have meeting rooms; hotel rooms have baths of their own. Every room can be reached from
/// every other without passing through a bedroom or bath, except that a bedroom's own bath is
/// reached through it. Stairs join the storeys, and windows are in outer walls. The same options
/// give the same plan on every platform.
/// \throws as check_options(); NoPlan if none of many draws succeeds, for instance because the
/// rooms of the kind hardly fit into the area
Plan make_plan(const PlanOptions& options);

}  // namespace enfilade::homes
