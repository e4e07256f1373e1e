#include <algorithm>

#include "enfilade/geometry/angle.h"
#include "enfilade/homes/furniture/furnish_recipes.h"

namespace enfilade::homes::furniture {
namespace {

/// The room's middle, with x along its longer sides.
Frame lengthwise(const FurnishedRoom& room) {
  return {room.middle().origin, room.width() > room.depth() ? 0U : 1U};
}

void runners(FurnishedRoom& room) {
  const double length = room.longest();
  const int n = std::max(1, static_cast<int>(length / 4.5));
  const double each = length / n;
  const Size size{std::max(1.2, each - 1.2), std::min(0.9, room.narrow() * 0.6), 0.010};
  for (int i = 0; i < n; ++i) {
    room.lay(shape_of("runner"), size, lengthwise(room), each * (i + 0.5) - length / 2, 0);
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
  const Size size{shape.size.w, shape.size.d, room.height()};
  const Frame middle = lengthwise(room);
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
    const Shape& mat = shape_of("doormat");
    room.lay(mat, mat.size, room.wall_frame(door->wall, door->middle()), 0, 0.42);
  }
  if (room.area() > 30) {
    columns(room);
    const Shape& counter = room.pick("counter");
    const Shape& chair = room.pick("office chair");
    const auto [w, d, h] = counter.size;
    const Group desk{w, d + 0.75, 0.6, {{counter, 0, 0.75 + d / 2}, {chair, 0, 0.37}}};
    room.place_at_wall(desk, near_middle);
  }
  const Shape& console = room.pick("console table");
  if (room.narrow() > 1.35) dressed_console(room, console, true);
  coat_hooks(room);
  if (room.area() > 4) {
    const Shape& bench = room.pick("bench");
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
  const Shape& clothes = shape_of("hanging clothes");
  for (int i = 0; i < 3; ++i) {
    Size size = clothes.size;
    size.w = std::min(room.between(0.9, 1.4), room.longest() - 0.3);
    // The shoes take the floor below.
    Group group{
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
  const Shape& mat = shape_of("exercise mat");
  room.lay(mat, mat.size, room.middle(), -0.5, 0);
  if (room.area() > 12) room.lay(mat, mat.size, room.middle(), 0.6, 0);
  for (int i = 0; i < 3; ++i) {
    const Shape& mirror = shape_of("mirror");
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
  const Shape& table = room.pick(room.chance(0.6) ? "pool table" : "ping pong table");
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
  const Shape& counter = room.pick("counter");
  const Shape& stool = room.pick("bar stool");
  const double w = std::clamp(room.longest() * 0.5, 1.4, 3.5), d = counter.size.d;
  Group bar{
      w, 1.0 + d + stool.size.d + 0.06, 0, {{counter, {w, d, counter.size.h}, 0, 1.0 + d / 2}}};
  for (double x = -w / 2 + 0.35; x < w / 2 - 0.2; x += 0.65) {
    bar.items.emplace_back(stool, x, 1.04 + d + stool.size.d / 2, 0, kPi);
  }
  if (const auto spot = room.place_at_wall(bar, near_middle)) {
    const Shape& shelf = shape_of("shelf", 1);
    room.hang(shelf, {std::min(1.6, w - 0.3), 0.22, 0.62}, spot->wall, spot->along, 1.25, 0.3);
    clutter(room, spot->frame, bar.items[0], "kitchen");
    for (const double x : {-w / 4, w / 4}) hang_pendant(room, spot->frame.to_world(x, 1.3));
  }
  const auto tables = static_cast<unsigned>(room.area() / 9);
  for (unsigned i = 0; i < tables; ++i) {
    const Shape& table = shape_of("kitchen table", 1);
    if (!table_with_chairs(room, table, table.size)) break;
  }
  finish(room, {.plants = 2, .pictures = 3});
}

void furnish_outdoors(FurnishedRoom& room, bool garden) {
  const Shape& table = room.pick("patio table");
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
