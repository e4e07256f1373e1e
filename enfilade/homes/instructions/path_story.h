/// \file  The facts of a path through a synthetic home, in order: turns, rooms, objects. Internal.
#pragma once
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/homes/instructions/speaker.h"

namespace enfilade::homes::instructions {

/// How people name a change of direction: below 20 degrees straight on, 20 to 60 slight, 60 to 130
/// a turn, beyond that around.
enum class TurnKind : std::uint8_t { kStraight, kSlight, kFull, kAround };
inline constexpr double kStraightBelow = 20, kSlightBelow = 60, kFullBelow = 130;
TurnKind turn_of(double degrees);

/// What happens on the way.
enum class HappeningKind : std::uint8_t {
  kCross,  ///< from one room into another
  kPass,   ///< past an object at one side
  kOver,   ///< over a rug
};
/// An event on the way: a room is entered, or an object is passed.
struct Happening {
  HappeningKind kind = HappeningKind::kCross;
  double metres = 0;                   ///< from the beginning of the stretch
  std::optional<std::size_t> opening;  ///< kCross; no value where rooms meet without a wall
  std::size_t from = 0, to = 0;        ///< kCross: rooms
  std::size_t thing = 0;
  bool on_right = false;  ///< kPass
  double salience = 0;
  ViewpointIndex seen_from;  ///< kPass, kOver: the viewpoint at the start of the leg
};

/// Several legs in one direction, or one flight of stairs.
struct PathStretch {
  double turn = 0;  ///< degrees before it, against the direction faced; right is positive
  int climb = 0;    ///< 1: up the stairs, -1: down
  bool from_storey = false, to_storey = false;  ///< the flight begins (ends) at a storey's floor
  double metres = 0, first_leg = 0;             ///< along the floor; to the next viewpoint
  std::size_t first = 0, last = 0;              ///< viewpoints, places in the path
  std::size_t room = 0, room_after = 0;
  std::vector<Happening> happenings;  ///< in order
  std::vector<std::size_t> ahead;     ///< objects in its direction, the most salient first
  unsigned door = 0;    ///< number of its first door on the side of the turn, counted since the
                        ///< last stretch began; 0: cannot be counted
  bool to_end = false;  ///< it ends at the far end of a long room
};

/// An object in view, for a given direction.
struct Neighbour {
  std::size_t thing = 0;
  double bearing = 0;  ///< degrees, right positive
  double gap = 0;      ///< metres along the floor to its box
  double salience = 0;
};

struct PathStart {
  std::size_t room = 0;
  std::vector<Neighbour> around;  ///< the most salient first
};

struct PathEnd {
  std::size_t room = 0;
  std::vector<Neighbour> near;              ///< within reach, the most fitting first
  std::optional<std::size_t> in_opening;    ///< the end is in a doorway
  std::optional<std::size_t> near_opening;  ///< the only one within 1.2 m
  int stairs = 0;                           ///< 1: at the top of a flight, -1: at the bottom
  bool on_stairs = false;                   ///< between two storeys
  bool just_inside = false;                 ///< entered the room less than 2.5 m ago
  bool in_middle = false, at_end = false;   ///< of the room; of a long room
};

struct PathStory {
  std::vector<PathStretch> stretches;
  PathStart start;
  PathEnd end;
};

/// Finds the facts of a path that begins with that heading (radians).
/// \pre at least two viewpoints, each adjacent to the next; all are in rooms
PathStory tell_path(const SpokenHome& home, std::span<const ViewpointIndex> viewpoints,
                    double heading);

}  // namespace enfilade::homes::instructions
