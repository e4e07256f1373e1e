#include <algorithm>
#include <array>
#include <cmath>

#include "enfilade/geometry/angle.h"
#include "enfilade/homes/furniture/furnish_recipes.h"

namespace enfilade::homes::furniture {
namespace {

/// A desk whose user sits on its room side, with what stands on it.
struct Workplace {
  Group group;
  Item desk;
};

Workplace workplace(FurnishedRoom& room, const Shape& desk, const Shape& chair) {
  Workplace place;
  place.desk = FurnishedRoom::item(desk, 0, desk.size.d / 2 + 0.015);
  place.group = {desk.size.w, desk.size.d + chair.size.d + 0.06, 0.15, {}};
  place.group.items.push_back(place.desk);
  place.group.items.push_back(FurnishedRoom::item(chair, room.between(-0.15, 0.15),
                                                  desk.size.d + 0.04 + chair.size.d / 2, 0, kPi));
  return place;
}

void dress_desk(FurnishedRoom& room, const Frame& frame, const Item& desk) {
  const double top = desk.z + desk.size.h, w = desk.size.w;
  const bool laptop = room.chance(0.35);
  if (laptop) {
    room.put(FurnishedRoom::item(FurnishedRoom::pick("laptop", 0), desk.x, desk.y + 0.02, top),
             frame);
  } else {
    room.put(FurnishedRoom::item(FurnishedRoom::pick("monitor", 0), desk.x, desk.y - 0.12, top),
             frame);
    room.put(FurnishedRoom::item(FurnishedRoom::pick("keyboard", 0), desk.x, desk.y + 0.17, top),
             frame);
  }
  if (room.chance(0.7)) {
    room.put(FurnishedRoom::item(FurnishedRoom::pick("desk lamp", 0), desk.x - w / 2 + 0.2,
                                 desk.y - 0.12, top),
             frame);
  }
  const Shape& pile = FurnishedRoom::pick(room.chance(0.6) ? "books" : "cups", 0);
  room.put(FurnishedRoom::item(pile, desk.x + w / 2 - 0.22, desk.y, top, room.between(-0.3, 0.3)),
           frame);
}

void cabinets_of_office(FurnishedRoom& room, unsigned shelves) {
  bookshelves(room, shelves);
  room.place_at_wall(room.pick("file cabinet"), in_corner, 0.5);
  put_in_corner(room, FurnishedRoom::pick("trash can", 0));
  plants(room, room.area() > 18 ? 3 : 1);
}

void board_on_wall(FurnishedRoom& room) {
  const Shape& board = room.pick(room.chance(0.6) ? "whiteboard" : "notice board");
  room.hang_anywhere(board, 0.95);
}

/// Desks face to face in the free middle of a large office.
void desk_islands(FurnishedRoom& room, unsigned at_most) {
  const Shape& desk = FurnishedRoom::pick("desk", 2);
  const Shape& chair = room.pick("office chair");
  const Rect& f = room.space().floor;
  for (unsigned i = 0; i < at_most; ++i) {
    Group group;
    const double reach = chair.size.d + 0.04;
    const double middle = reach + desk.size.d;
    group.w = 2 * desk.size.w + 0.02;
    group.d = 2 * middle;
    std::vector<Item> desks;
    for (const double x : {-desk.size.w / 2 - 0.005, desk.size.w / 2 + 0.005}) {
      desks.push_back(FurnishedRoom::item(desk, x, middle + desk.size.d / 2 + 0.003));
      desks.push_back(FurnishedRoom::item(desk, x, middle - desk.size.d / 2 - 0.003, 0, kPi));
      group.items.push_back(
          FurnishedRoom::item(chair, x, middle + desk.size.d + 0.05 + chair.size.d / 2, 0, kPi));
      group.items.push_back(
          FurnishedRoom::item(chair, x, middle - desk.size.d - 0.05 - chair.size.d / 2));
    }
    group.items.insert(group.items.end(), desks.begin(), desks.end());
    const auto frame = room.place_free(group, f.x0 + f.width() * room.between(0.2, 0.8),
                                       f.y0 + f.depth() * room.between(0.2, 0.8));
    if (!frame) break;
    for (const Item& item : desks) {
      if (item.turned == 0) {
        dress_desk(room, *frame, item);
        continue;
      }
      // The other side of the pair: the same, seen from there.
      Frame back = *frame;
      back.origin = frame->to_world(item.x, item.y);
      back.quarters += 2;
      dress_desk(room, back, FurnishedRoom::item(desk, 0, 0));
    }
  }
}

}  // namespace

void furnish_office(FurnishedRoom& room) {
  const Shape& desk = room.pick("desk");
  const Shape& chair = room.pick("office chair");
  if (room.area() > 26) desk_islands(room, static_cast<unsigned>(room.area() / 13));
  const unsigned desks = room.area() > 26 ? 2 : 1 + static_cast<unsigned>(room.area() / 14);
  for (unsigned i = 0; i < desks; ++i) {
    const Workplace place = workplace(room, desk, chair);
    const auto spot = room.place_at_wall(place.group, [](const Spot& s) {
      return (s.window ? 0.7 : 0.0) + 0.2 * std::min(s.door, 4.0) - 0.3 * s.off_centre;
    });
    if (!spot) break;
    dress_desk(room, spot->frame, place.desk);
  }
  cabinets_of_office(room, room.area() > 12 ? 2 : 1);
  if (room.area() > 13) reading_corner(room);
  if (room.area() > 22) {
    const Shape& table = FurnishedRoom::pick("round table", 0);
    const Frame m = room.middle();
    table_with_chairs(room, table, table.size, "chair", m.origin.x, m.origin.y);
    room.place_at_wall(FurnishedRoom::pick("flip chart", 0), in_corner, 0.2);
  }
  board_on_wall(room);
  room.hang_anywhere(room.pick("clock"), 1.8);
  dress_windows(room, false);
  hang_pictures(room, 2);
  hang_lights(room, room.area() > 16 ? Light::kPanels : Light::kHome);
}

void furnish_meeting(FurnishedRoom& room) {
  const Frame m = room.middle();
  const Shape& shape = room.pick("conference table");
  const double longest = std::max(room.width(), room.depth());
  std::optional<Frame> frame;
  Size size = shape.size;
  for (const double w : {longest - 2.6, longest - 3.2, 2.0, 1.5}) {
    if (frame || w < 1.4) continue;
    size = {std::min(w, 5.0), room.narrow() > 3.4 ? 1.2 : 0.9, 0.75};
    frame = table_with_chairs(room, shape, size, room.chance(0.5) ? "office chair" : "chair",
                              m.origin.x, m.origin.y);
  }
  if (!frame) {
    const Shape& table = FurnishedRoom::pick("round table", 0);
    table_with_chairs(room, table, table.size, "chair", m.origin.x, m.origin.y);
  }
  // What people look at hangs behind the table's ends, if it can.
  const Side wall = room.width() > room.depth() ? Side::kPlusX : Side::kPlusY;
  const auto [from, to] = room.wall_ends(wall);
  const Shape& screen = FurnishedRoom::pick("wall tv", 0);
  if (!room.hang(screen, {1.5, 0.06, 0.86}, wall, (from + to) / 2, 1.1, 0.6))
    room.hang_anywhere(screen, 1.1);
  const Shape& board = FurnishedRoom::pick("whiteboard", 0);
  if (!room.hang(board, board.size, opposite(wall), (from + to) / 2, 0.95, 0.6))
    room.hang_anywhere(board, 0.95);
  dressed_console(room, room.pick("sideboard"), false);
  if (room.area() > 18) room.place_at_wall(FurnishedRoom::pick("flip chart", 0), in_corner, 0.2);
  plants(room, 2);
  put_in_corner(room, FurnishedRoom::pick("trash can", 0));
  dress_windows(room, false);
  hang_pictures(room, 2);
  hang_lights(room, Light::kPanels);
}

void furnish_classroom(FurnishedRoom& room) {
  const Side wall = room.width() > room.depth() ? Side::kMinusX : Side::kMinusY;
  const auto [from, to] = room.wall_ends(wall);
  const Shape& board = FurnishedRoom::pick("whiteboard", 0);
  const double wide = std::min(3.0, to - from - 1);
  if (!room.hang(board, {wide, 0.03, 1.1}, wall, (from + to) / 2, 0.9, 0.5)) {
    room.hang_anywhere(board, 0.95);
  }
  const Shape& desk = FurnishedRoom::pick("desk", 1);
  const Shape& chair = FurnishedRoom::pick("chair", room.rng().below(2));
  const Frame front = room.wall_frame(wall, (from + to) / 2);
  const double deep = std::max(room.width(), room.depth());
  Group teacher{1.4, 0.7, 0, {}};
  teacher.items.push_back(FurnishedRoom::item(desk, 0, 0, 0, kPi));
  teacher.items.push_back(FurnishedRoom::item(chair, 0, -0.6));
  room.place(teacher, {front.to_world(0.5, 1.45), front.quarters});
  for (double y = 2.9; y < deep - 1.4; y += 1.45) {
    for (double x = -(to - from) / 2 + 1.2; x < (to - from) / 2 - 0.6; x += 1.75) {
      Group pupil{1.25, 1.2, 0, {}};
      pupil.items.push_back(FurnishedRoom::item(desk, 0, 0));
      pupil.items.back().size.d = 0.5;
      pupil.items.push_back(FurnishedRoom::item(chair, 0, 0.52, 0, kPi));
      room.place(pupil, {front.to_world(x, y), front.quarters});
    }
  }
  bookshelves(room, 2);
  room.hang_anywhere(room.pick("clock"), 1.9);
  room.hang_anywhere(FurnishedRoom::pick("notice board", 0), 1.0);
  plants(room, 2);
  dress_windows(room, false);
  hang_lights(room, Light::kPanels);
}

void furnish_library(FurnishedRoom& room) {
  bookshelves(room, 2 + static_cast<unsigned>(room.area() / 5));
  reading_corner(room);
  if (room.area() > 12) {
    const Shape& table = room.pick(room.chance(0.5) ? "dining table" : "round table");
    const Frame m = room.middle();
    const auto frame = table_with_chairs(room, table, table.size, "chair", m.origin.x, m.origin.y);
    if (frame) room.lay(FurnishedRoom::pick("rug", 0), {2.8, 2.2, 0.012}, *frame, 0, 0.9);
  } else {
    room.lay(FurnishedRoom::pick("rug", 0), {1.8, 1.3, 0.012}, room.middle(), 0, 0);
  }
  if (room.area() > 16) reading_corner(room);
  bookshelves(room, 2);
  plants(room, 2);
  dress_windows(room, true);
  hang_pictures(room, 1);
  hang_lights(room, Light::kChandelier);
}

void furnish_storage(FurnishedRoom& room, bool garage) {
  if (room.area() > 7) {
    const Shape& bench = FurnishedRoom::pick("work bench", 0);
    room.place_at_wall(bench, near_middle, 0.5);
  }
  const auto racks = 1 + static_cast<unsigned>(room.area() / 6);
  for (unsigned i = 0; i < std::min(racks, 6U); ++i) {
    room.place_at_wall(room.pick("storage shelf"), in_corner, 0.5);
  }
  if (garage) {
    room.place_at_wall(FurnishedRoom::pick("refrigerator", 0), in_corner, 0.5);
    room.place_at_wall(FurnishedRoom::pick("exercise bike", 0), in_corner, 0.3);
  } else if (room.area() > 5 && room.chance(0.5)) {
    room.place_at_wall(FurnishedRoom::pick("washing machine", 0), in_corner, 0.5);
  }
  room.place_at_wall(room.pick("cupboard"), in_corner, 0.5);
  for (unsigned i = 0; i < std::min(5U, racks + 1); ++i) put_in_corner(room, room.pick("box"));
  put_in_corner(room, FurnishedRoom::pick("trash can", 1));
  room.hang_anywhere(room.pick("shelf"), 1.5);
  hang_lights(room, garage ? Light::kPanels : Light::kHome);
}

}  // namespace enfilade::homes::furniture
