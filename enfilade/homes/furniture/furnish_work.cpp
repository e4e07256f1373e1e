#include <algorithm>

#include "enfilade/geometry/angle.h"
#include "enfilade/homes/furniture/furnish_room.h"

namespace enfilade::homes::furniture {
namespace {

/// A desk and a chair on its room side.
FurnitureGroup workplace(FurnishedRoom& room, const FurnitureShape& desk,
                         const FurnitureShape& chair) {
  const auto [w, d, h] = desk.size;
  const double x = room.between(-0.15, 0.15), y = d + 0.04 + chair.size.d / 2;
  return {w, d + chair.size.d + 0.06, 0.15, {{desk, 0, d / 2 + 0.015}, {chair, x, y, 0, kPi}}};
}

void dress_desk(FurnishedRoom& room, const GroupFrame& frame, const GroupItem& desk) {
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
  const FurnitureShape& pile = shape_of(room.chance(0.6) ? "books" : "cups");
  room.put({pile, desk.x + w / 2 - 0.22, desk.y, top, room.between(-0.3, 0.3)}, frame);
}

void cabinets_of_office(FurnishedRoom& room, unsigned shelves) {
  bookshelves(room, shelves);
  room.place_at_wall(room.pick("file cabinet"), in_corner, 0.5);
  put_in_corner(room, shape_of("trash can"));
  plants(room, room.area() > 18 ? 3 : 1);
}

/// Hangs it in the middle of the wall, or anywhere if it does not fit there.
void hang_on(FurnishedRoom& room, Side wall, const FurnitureShape& shape, FurnitureSize size,
             double low, double slide, double low_elsewhere) {
  const auto [from, to] = room.wall_ends(wall);
  if (room.hang(shape, size, wall, (from + to) / 2, low, slide)) return;
  room.hang_anywhere(shape, low_elsewhere);
}

/// Desks face to face in the free middle of a large office.
void desk_islands(FurnishedRoom& room, unsigned at_most) {
  const FurnitureShape& desk = shape_of("desk", 2);
  const FurnitureShape& chair = room.pick("office chair");
  const Rect& f = room.space().floor;
  const double w = desk.size.w, d = desk.size.d, middle = chair.size.d + 0.04 + d;
  std::vector<GroupItem> desks;
  FurnitureGroup group{2 * w + 0.02, 2 * middle, 0, {}};
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
    for (const GroupItem& item : desks) {
      if (item.turned == 0) {
        dress_desk(room, *frame, item);
        continue;
      }
      // The desk on the other side of the pair, in a frame that looks from there.
      GroupFrame back = *frame;
      back.origin = frame->to_world(item.x, item.y);
      back.quarters += 2;
      dress_desk(room, back, {desk, 0, 0});
    }
  }
}

}  // namespace

void furnish_office(FurnishedRoom& room) {
  const FurnitureShape& desk = room.pick("desk");
  const FurnitureShape& chair = room.pick("office chair");
  if (room.area() > 26) desk_islands(room, static_cast<unsigned>(room.area() / 13));
  const unsigned desks = room.area() > 26 ? 2 : 1 + static_cast<unsigned>(room.area() / 14);
  const Score score = [](const Spot& s) {
    return (s.window ? 0.7 : 0.0) + 0.2 * std::min(s.door, 4.0) - 0.3 * s.off_centre;
  };
  for (unsigned i = 0; i < desks; ++i) {
    const FurnitureGroup place = workplace(room, desk, chair);
    const auto spot = room.place_at_wall(place, score);
    if (!spot) break;
    dress_desk(room, spot->frame, place.items[0]);
  }
  cabinets_of_office(room, room.area() > 12 ? 2 : 1);
  if (room.area() > 13) reading_corner(room);
  if (room.area() > 22) {
    const FurnitureShape& table = shape_of("round table");
    table_with_chairs(room, table, table.size);
    room.place_at_wall(shape_of("flip chart"), in_corner, 0.2);
  }
  room.hang_anywhere(room.pick(room.chance(0.6) ? "whiteboard" : "notice board"), 0.95);
  room.hang_anywhere(room.pick("clock"), 1.8);
  const bool large = room.area() > 16;
  finish(room, {.pictures = 2, .light = large ? Light::kPanels : Light::kHome});
}

void furnish_meeting(FurnishedRoom& room) {
  const FurnitureShape& shape = room.pick("conference table");
  const double longest = room.longest();
  std::optional<GroupFrame> frame;
  FurnitureSize size = shape.size;
  for (const double w : {longest - 2.6, longest - 3.2, 2.0, 1.5}) {
    if (frame || w < 1.4) continue;
    size = {std::min(w, 5.0), room.narrow() > 3.4 ? 1.2 : 0.9, 0.75};
    frame = table_with_chairs(room, shape, size, room.chance(0.5) ? "office chair" : "chair");
  }
  const FurnitureShape& round = shape_of("round table");
  if (!frame) table_with_chairs(room, round, round.size);
  // The screen and the board hang behind the table's ends if they fit there.
  const Side wall = room.width() > room.depth() ? Side::kPlusX : Side::kPlusY;
  hang_on(room, wall, shape_of("wall tv"), {1.5, 0.06, 0.86}, 1.1, 0.6, 1.1);
  const FurnitureShape& board = shape_of("whiteboard");
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
  const FurnitureShape& desk = shape_of("desk", 1);
  const FurnitureShape& chair = shape_of("chair", room.rng().below(2));
  const GroupFrame front = room.wall_frame(wall, (from + to) / 2);
  const FurnitureGroup teacher{1.4, 0.7, 0, {{desk, 0, 0, 0, kPi}, {chair, 0, -0.6}}};
  room.place(teacher, {front.to_world(0.5, 1.45), front.quarters});
  const FurnitureSize small{desk.size.w, 0.5, desk.size.h};
  const FurnitureGroup pupil{1.25, 1.2, 0, {{desk, small, 0, 0}, {chair, 0, 0.52, 0, kPi}}};
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
    const FurnitureShape& table = room.pick(room.chance(0.5) ? "dining table" : "round table");
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

namespace {

/// The room's middle, with x along its longer sides.
GroupFrame lengthwise(const FurnishedRoom& room) {
  return {room.middle().origin, room.width() > room.depth() ? 0U : 1U};
}

void runners(FurnishedRoom& room) {
  const double length = room.longest();
  const int n = std::max(1, static_cast<int>(length / 4.5));
  const double each = length / n;
  const FurnitureSize size{std::max(1.2, each - 1.2), std::min(0.9, room.narrow() * 0.6), 0.010};
  for (int i = 0; i < n; ++i) {
    room.lay(shape_of("runner"), size, lengthwise(room), each * (i + 0.5) - length / 2, 0);
  }
}

void wall_lamps(FurnishedRoom& room, unsigned n) {
  const FurnitureShape& lamp = room.pick("wall lamp");
  for (unsigned i = 0; i < n; ++i) {
    if (!room.hang_anywhere(lamp, 1.75)) return;
  }
}

void columns(FurnishedRoom& room) {
  const FurnitureShape& shape = room.pick("column");
  const FurnitureSize size{shape.size.w, shape.size.d, room.height()};
  const GroupFrame middle = lengthwise(room);
  for (const double x : {-0.45, 0.45}) {
    for (const double y : {-0.28, 0.28}) {
      const Vec3d at = middle.to_world(x * (room.longest() / 2), y * room.narrow());
      room.place({size.w, size.d, 0, {{shape, size, 0, 0}}}, {at, middle.quarters});
    }
  }
}

}  // namespace

void furnish_entry(FurnishedRoom& room) {
  const auto& holes = room.space().holes;
  const auto door = std::find_if(holes.begin(), holes.end(), [](auto& h) { return h.is_door(); });
  if (door != holes.end()) {
    const FurnitureShape& mat = shape_of("doormat");
    room.lay(mat, mat.size, room.wall_frame(door->wall, door->middle()), 0, 0.42);
  }
  if (room.area() > 30) {
    columns(room);
    const FurnitureShape& counter = room.pick("counter");
    const FurnitureShape& chair = room.pick("office chair");
    const auto [w, d, h] = counter.size;
    const FurnitureGroup desk{w, d + 0.75, 0.6, {{counter, 0, 0.75 + d / 2}, {chair, 0, 0.37}}};
    room.place_at_wall(desk, near_middle);
  }
  const FurnitureShape& console = room.pick("console table");
  if (room.narrow() > 1.35) dressed_console(room, console, true);
  coat_hooks(room);
  if (room.area() > 4) {
    const FurnitureShape& bench = room.pick("bench");
    const auto spot = room.place_at_wall(bench, near_middle, 0.3);
    if (spot && bench.size.h < 0.5) {
      room.put({shape_of("cushion", 2), 0.3, bench.size.d / 2, bench.size.h}, spot->frame);
    }
    if (spot) put_in_corner(room, shape_of("shoes"));
  }
  if (room.area() > 7 && room.chance(0.5)) put_in_corner(room, shape_of("coat stand"));
  if (room.area() > 16) {
    room.place_at_wall(room.pick("loveseat"), near_middle, 0.5);
    reading_corner(room);
    room.lay(room.pick("rug"), {2.4, 1.8, 0.012}, room.middle(), 0, 0);
  }
  finish(room, {.plants = room.area() > 12 ? 4U : 1U,
                .curtains = true,
                .pictures = 2,
                .light = room.area() > 9 ? Light::kChandelier : Light::kHome});
}

void furnish_hallway(FurnishedRoom& room) {
  if (room.narrow() > 1.45) {
    const auto most = static_cast<unsigned>(room.longest() / 5) + 1;
    for (unsigned i = 0; i < most; ++i) {
      if (room.chance(0.3)) {
        room.place_at_wall(room.pick("bench"), near_middle, 0.2);
      } else {
        dressed_console(room, room.pick("console table"), true);
      }
    }
    plants(room, most);
  }
  if (room.narrow() > 2.6) {
    reading_corner(room);
    bookshelves(room, 1);
  }
  runners(room);
  hang_pictures(room, 2 + static_cast<unsigned>(room.area() / 5));
  if (room.chance(0.5)) wall_lamps(room, 2);
  dress_windows(room, true);
  hang_lights(room, Light::kHome);
}

void furnish_closet(FurnishedRoom& room) {
  const FurnitureShape& clothes = shape_of("hanging clothes");
  for (int i = 0; i < 3; ++i) {
    FurnitureSize size = clothes.size;
    size.w = std::min(room.between(0.9, 1.4), room.longest() - 0.3);
    // The shoes take the floor below.
    FurnitureGroup group{
        size.w,
        size.d + 0.05,
        0,
        {{clothes, size, 0, size.d / 2 + 0.03, 0.62}, {shape_of("shoes"), -size.w * 0.25, 0.3}}};
    if (i == 0) group.items.emplace_back(room.pick("box"), size.w * 0.2, 0.28);
    if (!room.place_at_wall(group, away_from_doors)) break;
    if (room.area() < 4) break;
  }
  room.place_at_wall(room.pick("chest of drawers"), in_corner, 0.4);
  if (room.area() > 5) {
    room.place_at_wall(room.pick("wardrobe"), in_corner, 0.5);
    put_in_corner(room, room.pick("ottoman"));
  }
  room.hang_anywhere(room.pick("shelf"), 1.6);
  if (room.chance(0.6)) room.hang_anywhere(shape_of("mirror"), 0.8);
  put_in_corner(room, room.pick("box"));
  put_in_corner(room, room.pick("basket"));
  hang_lights(room, Light::kHome);
}

void furnish_gym(FurnishedRoom& room) {
  const auto rounds = 1 + static_cast<unsigned>(room.area() / 22);
  for (unsigned i = 0; i < rounds; ++i) {
    room.place_at_wall(shape_of("treadmill"), near_middle, 0.3);
    room.place_at_wall(shape_of("exercise bike"), in_corner, 0.3);
    room.place_at_wall(shape_of("dumbbells"), near_middle, 0.6);
    room.place_at_wall(shape_of("weight bench"), in_corner, 0.3);
    if (room.area() > 14) room.place_at_wall(shape_of("rowing machine"), in_corner, 0.2);
  }
  put_in_corner(room, shape_of("exercise ball"));
  const FurnitureShape& mat = shape_of("exercise mat");
  room.lay(mat, mat.size, room.middle(), -0.5, 0);
  if (room.area() > 12) room.lay(mat, mat.size, room.middle(), 0.6, 0);
  for (int i = 0; i < 3; ++i) {
    const FurnitureShape& mirror = shape_of("mirror");
    for (const Side wall : kSides) {
      const auto [from, to] = room.wall_ends(wall);
      if (room.hang(mirror, {1.2, 0.03, 1.7}, wall, (from + to) / 2, 0.25, (to - from) / 2)) break;
    }
  }
  room.hang_anywhere(shape_of("wall tv"), 1.5);
  room.hang_anywhere(room.pick("clock"), 1.8);
  room.place_at_wall(room.pick("bench"), in_corner, 0.2);
  finish(room, {.plants = 1, .light = Light::kPanels});
}

void furnish_games(FurnishedRoom& room) {
  const FurnitureShape& table = room.pick(room.chance(0.6) ? "pool table" : "ping pong table");
  const double w = table.size.w + 1.0, d = table.size.d + 1.0;
  if (const auto frame = room.place_free({w, d, 0, {{table, 0, d / 2}}}, room.middle().origin)) {
    for (const double x : {-0.5, 0.5}) hang_pendant(room, frame->to_world(x, d / 2));
  }
  if (room.place_at_wall(room.pick("sofa"), near_middle, 0.5)) {
    room.hang_anywhere(shape_of("wall tv"), 1.15);
  }
  if (room.area() > 20) room.place_at_wall(room.pick("counter"), in_corner, 0.9);
  reading_corner(room);
  bookshelves(room, 1);
  finish(room, {.plants = 2, .curtains = true, .pictures = 3});
}

void furnish_bar(FurnishedRoom& room) {
  const FurnitureShape& counter = room.pick("counter");
  const FurnitureShape& stool = room.pick("bar stool");
  const double w = std::clamp(room.longest() * 0.5, 1.4, 3.5), d = counter.size.d;
  FurnitureGroup bar{
      w, 1.0 + d + stool.size.d + 0.06, 0, {{counter, {w, d, counter.size.h}, 0, 1.0 + d / 2}}};
  for (double x = -w / 2 + 0.35; x < w / 2 - 0.2; x += 0.65) {
    bar.items.emplace_back(stool, x, 1.04 + d + stool.size.d / 2, 0, kPi);
  }
  if (const auto spot = room.place_at_wall(bar, near_middle)) {
    const FurnitureShape& shelf = shape_of("shelf", 1);
    room.hang(shelf, {std::min(1.6, w - 0.3), 0.22, 0.62}, spot->wall, spot->along, 1.25, 0.3);
    clutter(room, spot->frame, bar.items[0], "kitchen");
    for (const double x : {-w / 4, w / 4}) hang_pendant(room, spot->frame.to_world(x, 1.3));
  }
  const auto tables = static_cast<unsigned>(room.area() / 9);
  for (unsigned i = 0; i < tables; ++i) {
    const FurnitureShape& table = shape_of("kitchen table", 1);
    if (!table_with_chairs(room, table, table.size)) break;
  }
  finish(room, {.plants = 2, .pictures = 3});
}

void furnish_outdoors(FurnishedRoom& room, bool garden) {
  const FurnitureShape& table = room.pick("patio table");
  if (room.narrow() > 1.8) {
    table_with_chairs(room, table, table.size, "patio chair");
  } else {
    for (int i = 0; i < 2; ++i) room.place_at_wall(shape_of("patio chair"), near_middle, 0.2);
  }
  room.place_at_wall(shape_of("bench", room.chance(0.5) ? 0 : 2), near_middle, 0.3);
  if (room.area() > 8) room.place_at_wall(shape_of("grill"), in_corner, 0.4);
  const unsigned green = 2 + static_cast<unsigned>(room.area() / 6);
  for (unsigned i = 0; i < std::min(green, 9U); ++i) {
    put_in_corner(room, garden || room.chance(0.4) ? shape_of("bush") : room.pick("plant"));
  }
  if (garden) {
    for (int i = 0; i < 4; ++i) room.place_at_wall(shape_of("fence"), near_middle, 0);
  }
  wall_lamps(room, 2);
}

}  // namespace enfilade::homes::furniture
