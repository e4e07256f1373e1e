/// \file  Furniture by kind of room.
#pragma once
#include <cstdint>
#include <optional>
#include <string_view>

#include "enfilade/homes/furniture/furnish_room.h"

namespace enfilade::homes::furniture {

// --- parts of many rooms (furnish_common.cpp) ---

/// Scores: nearer to the middle of a wall, in a corner, away from doors.
double near_middle(const Spot& spot);
double in_corner(const Spot& spot);
double away_from_doors(const Spot& spot);

enum class Light : std::uint8_t { kHome, kSpots, kPanels, kChandelier };
/// Lamps all over the ceiling, more in larger rooms.
void hang_lights(FurnishedRoom& room, Light kind);
/// One pendant above a place.
void hang_pendant(FurnishedRoom& room, Vec3d above);
/// Curtains where there is room for them, else blinds; some windows get neither.
void dress_windows(FurnishedRoom& room, bool curtains);
void hang_pictures(FurnishedRoom& room, unsigned at_most);
/// Puts a plant, a lamp or the like into a free corner.
bool put_in_corner(FurnishedRoom& room, const Shape& shape);
void plants(FurnishedRoom& room, unsigned at_most);
/// The last objects in a room, in this order.
struct Finish {
  unsigned plants = 0;    ///< at most
  bool curtains = false;  ///< for dress_windows()
  unsigned pictures = 0;  ///< at most
  Light light = Light::kHome;
};
void finish(FurnishedRoom& room, const Finish& what);
/// A table or cabinet at a wall with objects on it and a picture or mirror above.
void dressed_console(FurnishedRoom& room, const Shape& shape, bool mirror);
/// Small objects along the top of a piece.
void clutter(FurnishedRoom& room, const Frame& frame, const Item& below, std::string_view kind);
/// Armchair, lamp, small table.
void reading_corner(FurnishedRoom& room);
void bookshelves(FurnishedRoom& room, unsigned at_most);
/// Table with chairs around it, near the room's middle or `off` metres from it along x.
std::optional<Frame> table_with_chairs(FurnishedRoom& room, const Shape& table, Size size,
                                       std::string_view chair = "chair", double off = 0);
/// Along a wall: hooks with coats.
void coat_hooks(FurnishedRoom& room);

// --- rooms ---

void furnish_bedroom(FurnishedRoom& room);
void furnish_living(FurnishedRoom& room, bool television);
void furnish_dining(FurnishedRoom& room);
void furnish_booth(FurnishedRoom& room);
void furnish_kitchen(FurnishedRoom& room);
void furnish_bath(FurnishedRoom& room);
void furnish_toilet(FurnishedRoom& room);
void furnish_spa(FurnishedRoom& room);
void furnish_laundry(FurnishedRoom& room);
void furnish_office(FurnishedRoom& room);
void furnish_meeting(FurnishedRoom& room);
void furnish_classroom(FurnishedRoom& room);
void furnish_library(FurnishedRoom& room);
void furnish_entry(FurnishedRoom& room);
void furnish_hallway(FurnishedRoom& room);
void furnish_storage(FurnishedRoom& room, bool garage);
void furnish_closet(FurnishedRoom& room);
void furnish_gym(FurnishedRoom& room);
void furnish_games(FurnishedRoom& room);
void furnish_bar(FurnishedRoom& room);
void furnish_outdoors(FurnishedRoom& room, bool garden);

}  // namespace enfilade::homes::furniture
