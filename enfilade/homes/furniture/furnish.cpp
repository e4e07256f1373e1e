#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>
#include <vector>

#include "enfilade/geometry/angle.h"
#include "enfilade/homes/furniture/furnish_room.h"

namespace enfilade::homes::furniture {
namespace {

void furnish_stairwell(FurnishedRoom& room) {
  hang_pictures(room, 2);
  if (room.area() > 9) plants(room, 1);
  dress_windows(room, false);
  hang_lights(room, Light::kHome);
}

struct Recipe {
  std::string_view types;  ///< Matterport3D's region letters
  void (*furnish)(FurnishedRoom& room);
};

constexpr std::array kRecipes{
    Recipe{"b", furnish_bedroom},
    Recipe{"lfv", [](FurnishedRoom& room) { furnish_living(room, true); }},
    Recipe{"n", [](FurnishedRoom& room) { furnish_living(room, false); }},
    Recipe{"d", furnish_dining},
    Recipe{"D", furnish_booth},
    Recipe{"k", furnish_kitchen},
    Recipe{"a", furnish_bath},
    Recipe{"t", furnish_toilet},
    Recipe{"S", furnish_spa},
    Recipe{"j", furnish_laundry},
    Recipe{"o", furnish_office},
    Recipe{"m", furnish_meeting},
    Recipe{"C", furnish_classroom},
    Recipe{"i", furnish_library},
    Recipe{"e", furnish_entry},
    Recipe{"h", furnish_hallway},
    Recipe{"s", furnish_stairwell},
    Recipe{"c", furnish_closet},
    Recipe{"w", furnish_gym},
    Recipe{"r", furnish_games},
    Recipe{"B", furnish_bar},
    Recipe{"py", [](FurnishedRoom& room) { furnish_outdoors(room, false); }},
    Recipe{"x", [](FurnishedRoom& room) { furnish_outdoors(room, true); }},
    Recipe{"g", [](FurnishedRoom& room) { furnish_storage(room, true); }},
};

}  // namespace

void furnish(const looks::RoomSpace& space, const looks::RoomStyle& style, Rng& rng,
             looks::HomeParts parts) {
  FurnishedRoom room(space, style, rng, parts);
  const auto at = std::find_if(kRecipes.begin(), kRecipes.end(), [&](const Recipe& recipe) {
    return recipe.types.find(space.type) != std::string_view::npos;
  });
  if (at == kRecipes.end()) return furnish_storage(room, false);
  at->furnish(room);
}

double near_middle(const Spot& spot) {
  return -0.8 * spot.off_centre + 0.08 * std::min(spot.door, 5.0) - (spot.window ? 0.3 : 0);
}
double in_corner(const Spot& spot) {
  return (spot.corner < 0.12 ? 1.0 : -0.2 * std::min(spot.corner, 2.0)) +
         0.06 * std::min(spot.door, 5.0) - (spot.window ? 0.3 : 0);
}
double away_from_doors(const Spot& spot) { return 0.25 * std::min(spot.door, 6.0); }

void hang_lights(FurnishedRoom& room, Light kind) {
  const auto count = [](double length) {
    return std::max(1, static_cast<int>(std::lround(length / 4.3)));
  };
  const int nx = count(room.width()), ny = count(room.depth());
  const double each = room.area() / (nx * ny), tall = room.height() / 2.6;
  const bool large = kind == Light::kChandelier && room.height() > 2.75 && nx * ny == 1;
  const FurnitureShape& shape = large ? room.pick("chandelier")
                                : kind == Light::kSpots && room.chance(0.6) ? room.pick("spotlight")
                                : kind == Light::kPanels ? room.pick("ceiling light")
                                                         : room.pick("ceiling lamp");
  const GroupFrame centre = room.middle();
  for (int i = 0; i < nx; ++i) {
    for (int k = 0; k < ny; ++k) {
      GroupItem lamp(shape, room.width() * ((i + 0.5) / nx - 0.5),
                     room.depth() * ((k + 0.5) / ny - 0.5), room.height() - shape.size.h);
      if (room.depth() > room.width() && shape.size.w > 1.5 * shape.size.d) lamp.turned = kPi / 2;
      lamp.power = (2.6 + 0.17 * each) * tall * tall;
      room.put(lamp, centre);
    }
  }
}

void hang_pendant(FurnishedRoom& room, Vec3d above) {
  const FurnitureShape& shape = room.pick("hanging lamp");
  const double low = 1.62;
  if (room.height() < low + 0.45) return;
  GroupItem lamp(shape, 0, 0, low);
  lamp.size.h = room.height() - low;
  lamp.power = 1.6;
  room.put(lamp, {{above.x, above.y, room.space().floor_z}, 0});
}

void dress_windows(FurnishedRoom& room, bool curtains) {
  const FurnitureShape& curtain = room.pick("curtain");
  const FurnitureShape& blind = room.pick("blinds");
  for (const auto& hole : room.space().holes) {
    if (hole.is_door()) continue;
    const double wide = hole.to - hole.from, middle = hole.middle();
    const GroupFrame frame = room.wall_frame(hole.wall, middle);
    const auto [from, to] = room.wall_ends(hole.wall);
    const double w = std::min(wide + 0.6, 2 * std::min(middle - from, to - middle) - 0.02);
    if (curtains && w > wide + 0.1) {
      const double h = std::min(hole.head + 0.16, room.height() - 0.03);
      if (room.place({w, 0.15, 0, {{curtain, {w, 0.12, h}, 0, 0.075}}}, frame)) continue;
    }
    if (curtains || room.chance(0.6)) {
      const double h = std::min(blind.size.h, 0.4 * (hole.head - hole.sill));
      if (hole.head + 0.05 > room.height()) continue;
      const FurnitureSize size{wide + 0.06, blind.size.d, h};
      room.put_if_clear({blind, size, 0, size.d / 2 + 0.012, hole.head + 0.04 - h}, frame);
    }
  }
}

void hang_pictures(FurnishedRoom& room, unsigned at_most) {
  for (unsigned i = 0; i < at_most; ++i) {
    const FurnitureShape& shape = room.pick(room.chance(0.6) ? "picture" : "painting");
    if (!room.hang_anywhere(shape, 1.55 - shape.size.h / 2 + room.between(-0.05, 0.1))) return;
  }
}

void finish(FurnishedRoom& room, const Finish& what) {
  plants(room, what.plants);
  dress_windows(room, what.curtains);
  hang_pictures(room, what.pictures);
  hang_lights(room, what.light);
}

bool put_in_corner(FurnishedRoom& room, const FurnitureShape& shape) {
  return room.place_at_wall(shape, in_corner, 0).has_value();
}

void plants(FurnishedRoom& room, unsigned at_most) {
  for (unsigned i = 0; i < at_most; ++i) {
    if (!room.chance(0.75)) continue;
    const FurnitureShape& shape = room.pick("plant");
    if (shape.size.h > room.height() - 0.2) continue;
    put_in_corner(room, shape);
  }
}

void clutter(FurnishedRoom& room, const GroupFrame& frame, const GroupItem& below,
             std::string_view kind) {
  static const std::map<std::string_view, std::vector<std::string_view>> kThings{
      {"living", {"vase", "books", "bowl", "candles", "small plant", "sculpture", "flowers"}},
      {"table", {"fruit bowl", "flowers", "books", "cups"}},
      {"kitchen",
       {"fruit bowl", "bottles", "coffee maker", "toaster", "cups", "microwave", "small plant"}},
      {"bath", {"bottles", "towels", "small plant", "candles"}},
      {"store", {"box", "bottles", "basket", "toy box"}}};
  const auto& names = kThings.at(kind);
  const double w = below.size.w * 0.9;
  double at = -w / 2 + room.between(0.0, 0.2);
  while (at < w / 2 - 0.1) {
    const FurnitureShape& shape = room.pick(names[room.rng().below(names.size())]);
    const double turn = room.between(-0.25, 0.25);
    if (shape.size.d < below.size.d * 0.85 && at + shape.size.w < w / 2) {
      const double c = std::cos(below.turned), s = std::sin(below.turned);
      const double x = at + shape.size.w / 2, y = -0.05 * below.size.d;
      const double px = below.x + c * x - s * y, py = below.y + s * x + c * y;
      room.put({shape, px, py, below.z + below.size.h, below.turned + turn}, frame);
    }
    at += shape.size.w + room.between(0.1, 0.6);
  }
}

void dressed_console(FurnishedRoom& room, const FurnitureShape& shape, bool mirror) {
  const auto spot = room.place_at_wall(shape, near_middle, 0.4);
  const double top = shape.size.h;
  if (!spot || top >= 1.3) return;
  GroupItem item(shape, 0, shape.size.d / 2 + 0.015);
  const FurnitureShape& above = room.pick(mirror && room.chance(0.7) ? "mirror" : "picture");
  room.hang(above, *spot, std::max(1.0, top + 0.28), 0.3);
  if (shape.size.w > 0.9 && room.chance(0.6)) {
    const double x = (room.chance(0.5) ? 1 : -1) * (shape.size.w / 2 - 0.2);
    room.put({room.pick("table lamp"), x, item.y, top}, spot->frame);
    item.size.w -= 0.7;
    item.x = x > 0 ? -0.3 : 0.3;
  }
  clutter(room, spot->frame, item, "living");
}

void reading_corner(FurnishedRoom& room) {
  const FurnitureShape& chair = room.pick("armchair");
  const FurnitureShape& lamp = shape_of("floor lamp", room.rng().below(2));
  const FurnitureShape& table = room.pick("side table");
  FurnitureGroup group{
      chair.size.w + lamp.size.w + table.size.w + 0.1, chair.size.d + 0.12, 0.5, {}};
  double x = -group.w / 2;
  const auto add = [&](const FurnitureShape& shape, double y) {
    group.items.emplace_back(shape, x + shape.size.w / 2, y);
    x += shape.size.w + 0.05;
  };
  add(lamp, lamp.size.d / 2 + 0.1);
  add(chair, chair.size.d / 2 + 0.1);
  add(table, table.size.d / 2 + 0.2);
  const Score score = [](const Spot& s) { return in_corner(s) + (s.window ? 0.5 : 0.0); };
  const auto spot = room.place_at_wall(group, score);
  if (spot) clutter(room, spot->frame, group.items.back(), "table");
}

void bookshelves(FurnishedRoom& room, unsigned at_most) {
  const FurnitureShape& shape = room.pick("bookshelf");
  if (shape.size.h > room.height() - 0.1) return;
  const Score score = [](const Spot& s) { return in_corner(s) - (s.window ? 1 : 0); };
  for (unsigned i = 0; i < at_most; ++i) {
    const auto spot = room.place_at_wall(shape, score, 0.55);
    if (!spot) return;
    if (shape.size.h >= 1.2) continue;
    clutter(room, spot->frame, {shape, 0, shape.size.d / 2 + 0.015}, "living");
  }
}

std::optional<GroupFrame> table_with_chairs(FurnishedRoom& room, const FurnitureShape& table,
                                            FurnitureSize size, std::string_view chair_name,
                                            double off) {
  const FurnitureShape& chair = room.pick(chair_name);
  const double reach = chair.size.d / 2 + 0.03;
  const bool round = std::abs(size.w - size.d) < 0.01;
  FurnitureGroup group{size.w + 2 * chair.size.d + 0.1, size.d + 2 * chair.size.d + 0.1, 0, {}};
  const double middle = group.d / 2;
  const GroupItem top(table, size, 0, middle);
  group.items.push_back(top);
  const auto along = static_cast<int>(size.w / 0.62);
  for (int i = 0; i < std::max(1, along); ++i) {
    const double at = round ? 0 : size.w * ((i + 0.5) / along - 0.5);
    for (const double side : {-1.0, 1.0}) {
      const double y = middle + side * (size.d / 2 + reach);
      group.items.emplace_back(chair, at, y, 0, side > 0 ? kPi : 0);
    }
    if (round) break;
  }
  if (round || size.w > 1.5) {
    for (const double side : {-1.0, 1.0}) {
      group.items.emplace_back(chair, side * (size.w / 2 + reach), middle, 0, side * kPi / 2);
    }
  } else {
    group.w = size.w + 0.1;
  }
  Vec3d towards = room.middle().origin;
  towards.x += off;
  auto frame = room.place_free(group, towards);
  while (!frame && group.items.size() > 3) {  // fewer chairs, the last first
    group.items.pop_back();
    if (group.items.size() <= 5) group.w = std::min(group.w, size.w + 0.1);
    frame = room.place_free(group, towards);
  }
  if (frame) clutter(room, *frame, top, "table");
  return frame;
}

void coat_hooks(FurnishedRoom& room) {
  const FurnitureShape& rack = shape_of("coat rack");
  const FurnitureShape& coat = shape_of("coat");
  FurnitureGroup group{rack.size.w, 0.2, 0, {}};
  group.items.emplace_back(rack, 0, rack.size.d / 2 + 0.002, 1.62);
  const int coats = 1 + static_cast<int>(room.rng().below(2));
  for (int i = 0; i < coats; ++i) {
    const double tall = room.between(0.75, 0.95);
    const FurnitureSize size{0.42, 0.14, tall};
    group.items.emplace_back(coat, size, i == 0 ? -0.22 : 0.24, 0.10, 1.70 - tall);
  }
  room.place_at_wall(group, [](const Spot& s) { return 1 - 0.1 * s.door; });
}

}  // namespace enfilade::homes::furniture
