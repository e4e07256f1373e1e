/// \file  The steps in which a plan is drawn: rooms that are wanted, corridors, layout, check.
#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "enfilade/homes/plan/model.h"

namespace enfilade::homes::plan {

/// The usual sizes of a room type.
struct RoomSize {
  char type = '-';
  double least = 0, usual = 0, most = 0;  // m2
  double least_side = 0;                  // metres, between middle lines
};
const RoomSize& room_size(char type);

/// A piece of a strip that is decided on as a whole.
struct Item {
  enum class Shape : std::uint8_t {
    kRoom,       // the strip's whole depth
    kPair,       // one room at the corridor, another behind it, reached from a neighbour
    kSuite,      // a bedroom, and beside it a pair that is reached from it
    kHotelRoom,  // a bath and a small hall at the corridor, the bedroom behind
  };
  Shape shape = Shape::kRoom;
  char type = 'z', near = 'z', far = 'z';  // `type`: of a kRoom or the bedroom
  std::string name = {}, near_name = {}, far_name = {};
  std::string far_hosts = {};  // kPair: types through which the far room is reached
  double area = 0;             // wanted, m2, of all of it
};

/// Rooms that are laid side by side, in this order, as far as the strips allow.
struct Chain {
  std::vector<Item> items;
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
std::optional<Building> draw_building(const FrameNeeds& needs, Rng& rng);

struct Layout {
  std::vector<Cell> cells;  // the corridor's pieces first
  double score = 0;         // higher is better
};

/// The best of `trials` random orders of the program's rooms; no value if there is none. In it each
/// room fits, has windows if it needs them and is reached without passing private rooms.
std::optional<Layout> fill(const Building& building, unsigned storey,
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
