#include <algorithm>
#include <cmath>

#include "enfilade/geometry/angle.h"
#include "enfilade/homes/furniture/furnish_recipes.h"

namespace enfilade::homes::furniture {
namespace {

void runners(FurnishedRoom& room) {
  const bool along_x = room.width() > room.depth();
  const double length = std::max(room.width(), room.depth()),
               w = std::min(0.9, room.narrow() * 0.6);
  const Frame m = room.middle();
  const Frame frame{m.origin, along_x ? 0U : 1U};
  const int n = std::max(1, static_cast<int>(length / 4.5));
  const double each = length / n;
  for (int i = 0; i < n; ++i) {
    room.lay(FurnishedRoom::pick("runner", 0), {std::max(1.2, each - 1.2), w, 0.010}, frame,
             each * (i + 0.5) - length / 2, 0);
  }
}

void wall_lamps(FurnishedRoom& room, unsigned n) {
  const Shape& lamp = room.pick("wall lamp");
  for (unsigned i = 0; i < n; ++i) {
    if (!room.hang_anywhere(lamp, 1.75)) return;
  }
}

void columns(FurnishedRoom& room) {
  const Shape& shape = room.pick("column");
  const bool along_x = room.width() > room.depth();
  const Frame m = room.middle();
  const double length = std::max(room.width(), room.depth()) / 2;
  for (const double x : {-0.45, 0.45}) {
    for (const double y : {-0.28, 0.28}) {
      Group group{shape.size.w, shape.size.d, 0, {}};
      group.items.push_back(FurnishedRoom::item(shape, 0, 0));
      group.items[0].size.h = room.height();
      Frame frame{m.origin, along_x ? 0U : 1U};
      frame.origin = frame.to_world(x * length, y * room.narrow());
      room.place(group, frame);
    }
  }
}

}  // namespace

void furnish_entry(FurnishedRoom& room) {
  const auto doors = room.doors();
  if (!doors.empty()) {
    const auto& d = doors[0];
    const Shape& mat = FurnishedRoom::pick("doormat", 0);
    room.lay(mat, mat.size, room.wall_frame(d.wall, (d.from + d.to) / 2), 0, 0.42);
  }
  if (room.area() > 30) {
    columns(room);
    const Shape& counter = room.pick("counter");
    Group desk{counter.size.w, counter.size.d + 0.75, 0.6, {}};
    desk.items.push_back(FurnishedRoom::item(counter, 0, 0.75 + counter.size.d / 2));
    const Shape& chair = room.pick("office chair");
    desk.items.push_back(FurnishedRoom::item(chair, 0, 0.37));
    room.place_at_wall(desk, near_middle);
  }
  const Shape& console = room.pick("console table");
  if (room.narrow() > 1.35) dressed_console(room, console, true);
  coat_hooks(room);
  if (room.area() > 4) {
    const Shape& bench = room.pick("bench");
    const auto spot = room.place_at_wall(bench, near_middle, 0.3);
    if (spot && bench.size.h < 0.5) {
      room.put(FurnishedRoom::item(FurnishedRoom::pick("cushion", 2), 0.3, bench.size.d / 2,
                                   bench.size.h),
               spot->frame);
    }
    if (spot) put_in_corner(room, FurnishedRoom::pick("shoes", 0));
  }
  if (room.area() > 7 && room.chance(0.5))
    put_in_corner(room, FurnishedRoom::pick("coat stand", 0));
  if (room.area() > 16) {
    room.place_at_wall(room.pick("loveseat"), near_middle, 0.5);
    reading_corner(room);
    room.lay(room.pick("rug"), {2.4, 1.8, 0.012}, room.middle(), 0, 0);
  }
  plants(room, room.area() > 12 ? 4 : 1);
  dress_windows(room, true);
  hang_pictures(room, 2);
  hang_lights(room, room.area() > 9 ? Light::kChandelier : Light::kHome);
}

void furnish_hallway(FurnishedRoom& room) {
  if (room.narrow() > 1.45) {
    const auto most = static_cast<unsigned>(std::max(room.width(), room.depth()) / 5) + 1;
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
  const Shape& clothes = FurnishedRoom::pick("hanging clothes", 0);
  for (int i = 0; i < 3; ++i) {
    Size size = clothes.size;
    size.w = std::min(room.between(0.9, 1.4), std::max(room.width(), room.depth()) - 0.3);
    Group group{size.w, size.d + 0.05, 0, {}};
    group.items.push_back({&clothes, size, 0, size.d / 2 + 0.03, 0.62, 0, 1});
    // The floor below is taken too.
    const Shape& shoes = FurnishedRoom::pick("shoes", 0);
    group.items.push_back(FurnishedRoom::item(shoes, -size.w * 0.25, 0.3));
    if (i == 0) group.items.push_back(FurnishedRoom::item(room.pick("box"), size.w * 0.2, 0.28));
    if (!room.place_at_wall(group, away_from_doors)) break;
    if (room.area() < 4) break;
  }
  room.place_at_wall(room.pick("chest of drawers"), in_corner, 0.4);
  if (room.area() > 5) {
    room.place_at_wall(room.pick("wardrobe"), in_corner, 0.5);
    put_in_corner(room, room.pick("ottoman"));
  }
  room.hang_anywhere(room.pick("shelf"), 1.6);
  if (room.chance(0.6)) room.hang_anywhere(FurnishedRoom::pick("mirror", 0), 0.8);
  put_in_corner(room, room.pick("box"));
  put_in_corner(room, room.pick("basket"));
  hang_lights(room, Light::kHome);
}

void furnish_gym(FurnishedRoom& room) {
  const auto rounds = 1 + static_cast<unsigned>(room.area() / 22);
  for (unsigned i = 0; i < rounds; ++i) {
    room.place_at_wall(FurnishedRoom::pick("treadmill", 0), near_middle, 0.3);
    room.place_at_wall(FurnishedRoom::pick("exercise bike", 0), in_corner, 0.3);
    room.place_at_wall(FurnishedRoom::pick("dumbbells", 0), near_middle, 0.6);
    room.place_at_wall(FurnishedRoom::pick("weight bench", 0), in_corner, 0.3);
    if (room.area() > 14)
      room.place_at_wall(FurnishedRoom::pick("rowing machine", 0), in_corner, 0.2);
  }
  put_in_corner(room, FurnishedRoom::pick("exercise ball", 0));
  const Shape& mat = FurnishedRoom::pick("exercise mat", 0);
  room.lay(mat, mat.size, room.middle(), -0.5, 0);
  if (room.area() > 12) room.lay(mat, mat.size, room.middle(), 0.6, 0);
  for (int i = 0; i < 3; ++i) {
    const Shape& mirror = FurnishedRoom::pick("mirror", 0);
    for (const Side wall : kSides) {
      const auto [from, to] = room.wall_ends(wall);
      if (room.hang(mirror, {1.2, 0.03, 1.7}, wall, (from + to) / 2, 0.25, (to - from) / 2)) break;
    }
  }
  room.hang_anywhere(FurnishedRoom::pick("wall tv", 0), 1.5);
  room.hang_anywhere(room.pick("clock"), 1.8);
  room.place_at_wall(room.pick("bench"), in_corner, 0.2);
  plants(room, 1);
  dress_windows(room, false);
  hang_lights(room, Light::kPanels);
}

void furnish_games(FurnishedRoom& room) {
  const Frame m = room.middle();
  const Shape& table = room.pick(room.chance(0.6) ? "pool table" : "ping pong table");
  Group game{table.size.w + 1.0, table.size.d + 1.0, 0, {}};
  game.items.push_back(FurnishedRoom::item(table, 0, game.d / 2));
  const auto frame = room.place_free(game, m.origin.x, m.origin.y);
  if (frame) {
    hang_pendant(room, frame->to_world(-0.5, game.d / 2));
    hang_pendant(room, frame->to_world(0.5, game.d / 2));
  }
  if (room.place_at_wall(room.pick("sofa"), near_middle, 0.5)) {
    room.hang_anywhere(FurnishedRoom::pick("wall tv", 0), 1.15);
  }
  if (room.area() > 20) {
    const Shape& bar = room.pick("counter");
    room.place_at_wall(bar, in_corner, 0.9);
  }
  reading_corner(room);
  bookshelves(room, 1);
  plants(room, 2);
  dress_windows(room, true);
  hang_pictures(room, 3);
  hang_lights(room, Light::kHome);
}

void furnish_bar(FurnishedRoom& room) {
  const Shape& counter = room.pick("counter");
  const Shape& stool = room.pick("bar stool");
  const double w = std::clamp(std::max(room.width(), room.depth()) * 0.5, 1.4, 3.5);
  Group bar{w, 1.0 + counter.size.d + stool.size.d + 0.06, 0, {}};
  bar.items.push_back(
      {&counter, {w, counter.size.d, counter.size.h}, 0, 1.0 + counter.size.d / 2, 0, 0, 1});
  for (double x = -w / 2 + 0.35; x < w / 2 - 0.2; x += 0.65) {
    bar.items.push_back(
        FurnishedRoom::item(stool, x, 1.04 + counter.size.d + stool.size.d / 2, 0, kPi));
  }
  if (const auto spot = room.place_at_wall(bar, near_middle)) {
    const Shape& shelf = FurnishedRoom::pick("shelf", 1);
    room.hang(shelf, {std::min(1.6, w - 0.3), 0.22, 0.62}, spot->wall, spot->along, 1.25, 0.3);
    clutter(room, spot->frame, bar.items[0], "kitchen");
    hang_pendant(room, spot->frame.to_world(-w / 4, 1.3));
    hang_pendant(room, spot->frame.to_world(w / 4, 1.3));
  }
  const Frame m = room.middle();
  const auto tables = static_cast<unsigned>(room.area() / 9);
  for (unsigned i = 0; i < tables; ++i) {
    const Shape& table = FurnishedRoom::pick("kitchen table", 1);
    if (!table_with_chairs(room, table, table.size, "chair", m.origin.x, m.origin.y)) break;
  }
  plants(room, 2);
  dress_windows(room, false);
  hang_pictures(room, 3);
  hang_lights(room, Light::kHome);
}

void furnish_outdoors(FurnishedRoom& room, bool garden) {
  const Frame m = room.middle();
  const Shape& table = room.pick("patio table");
  if (room.narrow() > 1.8) {
    table_with_chairs(room, table, table.size, "patio chair", m.origin.x, m.origin.y);
  } else {
    for (int i = 0; i < 2; ++i)
      room.place_at_wall(FurnishedRoom::pick("patio chair", 0), near_middle, 0.2);
  }
  room.place_at_wall(FurnishedRoom::pick("bench", room.chance(0.5) ? 0 : 2), near_middle, 0.3);
  if (room.area() > 8) room.place_at_wall(FurnishedRoom::pick("grill", 0), in_corner, 0.4);
  const unsigned green = 2 + static_cast<unsigned>(room.area() / 6);
  for (unsigned i = 0; i < std::min(green, 9U); ++i) {
    put_in_corner(room,
                  garden || room.chance(0.4) ? FurnishedRoom::pick("bush", 0) : room.pick("plant"));
  }
  if (garden) {
    for (int i = 0; i < 4; ++i) room.place_at_wall(FurnishedRoom::pick("fence", 0), near_middle, 0);
  }
  wall_lamps(room, 2);
}

}  // namespace enfilade::homes::furniture
