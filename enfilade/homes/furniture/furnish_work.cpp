#include <algorithm>

#include "enfilade/geometry/angle.h"
#include "enfilade/homes/furniture/furnish_recipes.h"

namespace enfilade::homes::furniture {
namespace {

/// A desk and a chair on its room side.
Group workplace(FurnishedRoom& room, const Shape& desk, const Shape& chair) {
  const auto [w, d, h] = desk.size;
  const double x = room.between(-0.15, 0.15), y = d + 0.04 + chair.size.d / 2;
  return {w, d + chair.size.d + 0.06, 0.15, {{desk, 0, d / 2 + 0.015}, {chair, x, y, 0, kPi}}};
}

void dress_desk(FurnishedRoom& room, const Frame& frame, const Item& desk) {
  const double top = desk.z + desk.size.h, w = desk.size.w;
  const bool laptop = room.chance(0.35);
  if (laptop) {
    room.put({shape_of("laptop"), desk.x, desk.y + 0.02, top}, frame);
  } else {
    room.put({shape_of("monitor"), desk.x, desk.y - 0.12, top}, frame);
    room.put({shape_of("keyboard"), desk.x, desk.y + 0.17, top}, frame);
  }
  if (room.chance(0.7)) {
    room.put({shape_of("desk lamp"), desk.x - w / 2 + 0.2, desk.y - 0.12, top}, frame);
  }
  const Shape& pile = shape_of(room.chance(0.6) ? "books" : "cups");
  room.put({pile, desk.x + w / 2 - 0.22, desk.y, top, room.between(-0.3, 0.3)}, frame);
}

void cabinets_of_office(FurnishedRoom& room, unsigned shelves) {
  bookshelves(room, shelves);
  room.place_at_wall(room.pick("file cabinet"), in_corner, 0.5);
  put_in_corner(room, shape_of("trash can"));
  plants(room, room.area() > 18 ? 3 : 1);
}

/// Hangs it in the middle of the wall, or anywhere if it does not fit there.
void hang_on(FurnishedRoom& room, Side wall, const Shape& shape, Size size, double low,
             double slide, double low_elsewhere) {
  const auto [from, to] = room.wall_ends(wall);
  if (room.hang(shape, size, wall, (from + to) / 2, low, slide)) return;
  room.hang_anywhere(shape, low_elsewhere);
}

/// Desks face to face in the free middle of a large office.
void desk_islands(FurnishedRoom& room, unsigned at_most) {
  const Shape& desk = shape_of("desk", 2);
  const Shape& chair = room.pick("office chair");
  const Rect& f = room.space().floor;
  const double w = desk.size.w, d = desk.size.d, middle = chair.size.d + 0.04 + d;
  std::vector<Item> desks;
  Group group{2 * w + 0.02, 2 * middle, 0, {}};
  for (const double x : {-w / 2 - 0.005, w / 2 + 0.005}) {
    desks.emplace_back(desk, x, middle + d / 2 + 0.003);
    desks.emplace_back(desk, x, middle - d / 2 - 0.003, 0, kPi);
    group.items.emplace_back(chair, x, middle + d + 0.05 + chair.size.d / 2, 0, kPi);
    group.items.emplace_back(chair, x, middle - d - 0.05 - chair.size.d / 2);
  }
  group.items.insert(group.items.end(), desks.begin(), desks.end());
  for (unsigned i = 0; i < at_most; ++i) {
    const double y = f.y0 + f.depth() * room.between(0.2, 0.8);
    const double x = f.x0 + f.width() * room.between(0.2, 0.8);
    const auto frame = room.place_free(group, {x, y, 0});
    if (!frame) break;
    for (const Item& item : desks) {
      if (item.turned == 0) {
        dress_desk(room, *frame, item);
        continue;
      }
      // The desk on the other side of the pair, in a frame that looks from there.
      Frame back = *frame;
      back.origin = frame->to_world(item.x, item.y);
      back.quarters += 2;
      dress_desk(room, back, {desk, 0, 0});
    }
  }
}

}  // namespace

void furnish_office(FurnishedRoom& room) {
  const Shape& desk = room.pick("desk");
  const Shape& chair = room.pick("office chair");
  if (room.area() > 26) desk_islands(room, static_cast<unsigned>(room.area() / 13));
  const unsigned desks = room.area() > 26 ? 2 : 1 + static_cast<unsigned>(room.area() / 14);
  const Score score = [](const Spot& s) {
    return (s.window ? 0.7 : 0.0) + 0.2 * std::min(s.door, 4.0) - 0.3 * s.off_centre;
  };
  for (unsigned i = 0; i < desks; ++i) {
    const Group place = workplace(room, desk, chair);
    const auto spot = room.place_at_wall(place, score);
    if (!spot) break;
    dress_desk(room, spot->frame, place.items[0]);
  }
  cabinets_of_office(room, room.area() > 12 ? 2 : 1);
  if (room.area() > 13) reading_corner(room);
  if (room.area() > 22) {
    const Shape& table = shape_of("round table");
    table_with_chairs(room, table, table.size);
    room.place_at_wall(shape_of("flip chart"), in_corner, 0.2);
  }
  room.hang_anywhere(room.pick(room.chance(0.6) ? "whiteboard" : "notice board"), 0.95);
  room.hang_anywhere(room.pick("clock"), 1.8);
  const bool large = room.area() > 16;
  finish(room, {.pictures = 2, .light = large ? Light::kPanels : Light::kHome});
}

void furnish_meeting(FurnishedRoom& room) {
  const Shape& shape = room.pick("conference table");
  const double longest = room.longest();
  std::optional<Frame> frame;
  Size size = shape.size;
  for (const double w : {longest - 2.6, longest - 3.2, 2.0, 1.5}) {
    if (frame || w < 1.4) continue;
    size = {std::min(w, 5.0), room.narrow() > 3.4 ? 1.2 : 0.9, 0.75};
    frame = table_with_chairs(room, shape, size, room.chance(0.5) ? "office chair" : "chair");
  }
  const Shape& round = shape_of("round table");
  if (!frame) table_with_chairs(room, round, round.size);
  // The screen and the board hang behind the table's ends if they fit there.
  const Side wall = room.width() > room.depth() ? Side::kPlusX : Side::kPlusY;
  hang_on(room, wall, shape_of("wall tv"), {1.5, 0.06, 0.86}, 1.1, 0.6, 1.1);
  const Shape& board = shape_of("whiteboard");
  hang_on(room, opposite(wall), board, board.size, 0.95, 0.6, 0.95);
  dressed_console(room, room.pick("sideboard"), false);
  if (room.area() > 18) room.place_at_wall(shape_of("flip chart"), in_corner, 0.2);
  plants(room, 2);
  put_in_corner(room, shape_of("trash can"));
  finish(room, {.pictures = 2, .light = Light::kPanels});
}

void furnish_classroom(FurnishedRoom& room) {
  const Side wall = room.width() > room.depth() ? Side::kMinusX : Side::kMinusY;
  const auto [from, to] = room.wall_ends(wall);
  const double wide = std::min(3.0, to - from - 1);
  hang_on(room, wall, shape_of("whiteboard"), {wide, 0.03, 1.1}, 0.9, 0.5, 0.95);
  const Shape& desk = shape_of("desk", 1);
  const Shape& chair = shape_of("chair", room.rng().below(2));
  const Frame front = room.wall_frame(wall, (from + to) / 2);
  const Group teacher{1.4, 0.7, 0, {{desk, 0, 0, 0, kPi}, {chair, 0, -0.6}}};
  room.place(teacher, {front.to_world(0.5, 1.45), front.quarters});
  const Size small{desk.size.w, 0.5, desk.size.h};
  const Group pupil{1.25, 1.2, 0, {{desk, small, 0, 0}, {chair, 0, 0.52, 0, kPi}}};
  for (double y = 2.9; y < room.longest() - 1.4; y += 1.45) {
    for (double x = -(to - from) / 2 + 1.2; x < (to - from) / 2 - 0.6; x += 1.75) {
      room.place(pupil, {front.to_world(x, y), front.quarters});
    }
  }
  bookshelves(room, 2);
  room.hang_anywhere(room.pick("clock"), 1.9);
  room.hang_anywhere(shape_of("notice board"), 1.0);
  finish(room, {.plants = 2, .light = Light::kPanels});
}

void furnish_library(FurnishedRoom& room) {
  bookshelves(room, 2 + static_cast<unsigned>(room.area() / 5));
  reading_corner(room);
  if (room.area() > 12) {
    const Shape& table = room.pick(room.chance(0.5) ? "dining table" : "round table");
    const auto frame = table_with_chairs(room, table, table.size);
    if (frame) room.lay(shape_of("rug"), {2.8, 2.2, 0.012}, *frame, 0, 0.9);
  } else {
    room.lay(shape_of("rug"), {1.8, 1.3, 0.012}, room.middle(), 0, 0);
  }
  if (room.area() > 16) reading_corner(room);
  bookshelves(room, 2);
  finish(room, {.plants = 2, .curtains = true, .pictures = 1, .light = Light::kChandelier});
}

void furnish_storage(FurnishedRoom& room, bool garage) {
  if (room.area() > 7) room.place_at_wall(shape_of("work bench"), near_middle, 0.5);
  const auto racks = 1 + static_cast<unsigned>(room.area() / 6);
  for (unsigned i = 0; i < std::min(racks, 6U); ++i) {
    room.place_at_wall(room.pick("storage shelf"), in_corner, 0.5);
  }
  if (garage) {
    room.place_at_wall(shape_of("refrigerator"), in_corner, 0.5);
    room.place_at_wall(shape_of("exercise bike"), in_corner, 0.3);
  } else if (room.area() > 5 && room.chance(0.5)) {
    room.place_at_wall(shape_of("washing machine"), in_corner, 0.5);
  }
  room.place_at_wall(room.pick("cupboard"), in_corner, 0.5);
  for (unsigned i = 0; i < std::min(5U, racks + 1); ++i) put_in_corner(room, room.pick("box"));
  put_in_corner(room, shape_of("trash can", 1));
  room.hang_anywhere(room.pick("shelf"), 1.5);
  hang_lights(room, garage ? Light::kPanels : Light::kHome);
}

}  // namespace enfilade::homes::furniture
