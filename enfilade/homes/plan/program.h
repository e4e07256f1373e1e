/// \file  Which rooms a storey is to have, and how large.
#pragma once
#include <string>
#include <vector>

#include "enfilade/homes/plan/model.h"

namespace enfilade::homes::plan {

/// What is known of a room type: sizes at which people build it.
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
  std::string name, near_name, far_name;
  std::string far_hosts;  // kPair: types through which the far room is reached
  double area = 0;        // wanted, m2, of all of it
};

/// Rooms that like to stand side by side, in this order.
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

}  // namespace enfilade::homes::plan
