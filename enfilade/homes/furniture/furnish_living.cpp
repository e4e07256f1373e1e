#include <algorithm>
#include <array>

#include "enfilade/geometry/angle.h"
#include "enfilade/homes/furniture/furnish_room.h"

namespace enfilade::homes::furniture {
namespace {

/// A bed with 0 to 2 nightstands.
FurnitureGroup bed_group(const FurnitureShape& bed, const FurnitureShape& night, int nights) {
  const FurnitureSize b = bed.size;
  const double side = night.size.w + 0.06, shift = nights == 1 ? side / 2 : 0;
  FurnitureGroup group{b.w + side * nights, b.d + 0.02, 0.45, {{bed, shift, b.d / 2 + 0.015}}};
  const double y = night.size.d / 2 + 0.03, x = b.w / 2 + side / 2 + 0.01;
  if (nights > 0) group.items.emplace_back(night, shift - x, y);
  if (nights > 1) group.items.emplace_back(night, shift + x, y);
  return group;
}

/// The bed's place, if one was found; with fewer nightstands where the room is small.
std::optional<Spot> place_bed(FurnishedRoom& room, const FurnitureShape& bed,
                              FurnitureGroup& group) {
  const FurnitureShape& night = room.pick("nightstand");
  const Score score = [&](const Spot& s) {
    return 0.35 * std::min(s.door, 4.0) - 0.7 * s.off_centre - (s.window ? 0.5 : 0);
  };
  for (const int nights : {2, 1, 0}) {
    group = bed_group(bed, night, nights);
    if (nights < 2) group.front = 0;
    if (const auto spot = room.place_at_wall(group, score)) return spot;
  }
  return std::nullopt;
}

void dress_bed(FurnishedRoom& room, const Spot& spot, const FurnitureGroup& group) {
  const GroupItem& bed = group.items[0];
  const FurnitureShape& lamp = room.pick("table lamp");
  for (std::size_t i = 1; i < group.items.size(); ++i) {
    const GroupItem& night = group.items[i];
    room.put({lamp, night.x, night.y, night.size.h}, spot.frame);
  }
  if (room.chance(0.8)) {
    const FurnitureShape& rug = shape_of("rug", room.chance(0.75) ? 0 : 1);
    room.lay(rug, {bed.size.w + 1.1, 1.5, rug.size.h}, spot.frame, bed.x,
             bed.y + bed.size.d / 2 - 0.3);
  }
  if (bed.size.h < 1.5) {
    const FurnitureShape& picture = room.pick(room.chance(0.5) ? "painting" : "picture");
    room.hang(picture, spot, std::max(1.25, bed.size.h + 0.2), 0.4);
  }
  const FurnitureShape& cushion = shape_of("cushion");
  for (const double side : {-0.22, 0.22}) {
    if (bed.size.w < 1.2 && side > 0) break;
    const double x = bed.x + (bed.size.w < 1.2 ? 0 : side * 1.2);
    room.put({cushion, x, 0.62, 0.56, room.between(-0.2, 0.2)}, spot.frame);
  }
}

void kids_corner(FurnishedRoom& room) {
  if (put_in_corner(room, room.pick("toy box")) && room.chance(0.5)) {
    put_in_corner(room, room.pick("stuffed animal"));
  }
}

void bedroom_extras(FurnishedRoom& room) {
  const Score by_wall = [](const Spot& s) { return in_corner(s) - (s.window ? 0.6 : 0); };
  room.place_at_wall(room.pick("wardrobe"), by_wall, 0.6);
  if (room.area() > 10.5) {
    const bool wide = room.chance(0.65);
    dressed_console(room, room.pick(wide ? "dresser" : "chest of drawers"), wide);
  }
  if (room.area() > 13 && room.chance(0.5)) reading_corner(room);
  if (room.area() > 15 && room.chance(0.5)) {
    room.place_at_wall(room.pick("tv stand"), near_middle, 0.4);
  }
  if (room.chance(0.35)) put_in_corner(room, shape_of("standing mirror"));
  if (room.area() > 18) bookshelves(room, 1);
  plants(room, room.area() > 12 ? 2 : 1);
  if (room.chance(0.4)) put_in_corner(room, room.pick("basket"));
}

}  // namespace

void furnish_bedroom(FurnishedRoom& room) {
  const bool curtains = room.chance(0.7);
  if (curtains) dress_windows(room, true);  // first, while nothing stands below the window
  const bool small = room.area() < 8.5 || room.narrow() < 2.6;
  const bool kids = small || (room.area() < 13 && room.chance(0.3));
  const FurnitureShape& bed =
      kids ? (room.height() > 2.4 && room.chance(0.25) ? room.pick("bunk bed")
                                                       : room.pick("single bed"))
           : room.pick("bed");
  FurnitureGroup group;
  auto spot = place_bed(room, bed, group);
  if (!spot) spot = place_bed(room, shape_of("single bed"), group);
  if (spot) dress_bed(room, *spot, group);
  if (spot && kids && room.area() > 11) {  // a second one
    FurnitureGroup second;
    const auto other = place_bed(room, bed, second);
    if (other) dress_bed(room, *other, second);
  }
  bedroom_extras(room);
  if (kids) kids_corner(room);
  if (!curtains) dress_windows(room, false);
  hang_pictures(room, room.area() > 12 ? 2 : 1);
  hang_lights(room, Light::kHome);
}

namespace {

/// Seats around a table before something to look at, in the frame of the wall that it stands at.
struct Seating {
  const FurnitureShape *focal, *sofa, *table, *chair;
  int chairs = 0;
  double table_y = 0;  ///< of its middle, metres from the wall
  FurnitureGroup group;
};

void arrange(Seating& s, double depth) {
  const FurnitureSize f = s.focal->size, sofa = s.sofa->size, t = s.table->size;
  const double least = f.d + 0.8 + t.d + 0.4 + sofa.d;
  // Against the opposite wall if too little room is left behind the sofa to walk.
  const double back = depth - least < 1.05 ? depth - 0.02 : std::min(least + 0.6, depth - 1.0);
  const double sofa_y = back - sofa.d / 2;
  s.table_y = back - sofa.d - 0.4 - t.d / 2;
  const double w = std::max(f.w, sofa.w);
  s.group = {w, f.d, 0, {{*s.focal, 0, f.d / 2 + 0.015}, {*s.sofa, 0, sofa_y, 0, kPi}}};
  if (s.table_y - t.d / 2 > f.d + 0.5) {
    s.group.items.emplace_back(*s.table, 0, s.table_y);
  } else {
    s.chairs = 0;  // too narrow for more than a sofa
  }
  const double x = std::max(t.w / 2 + 0.42, sofa.w / 2 - 0.2) + s.chair->size.d / 2 + 0.12;
  for (int i = 0; i < s.chairs; ++i) {
    const double side = i == 0 ? 1 : -1;
    s.group.items.emplace_back(*s.chair, side * x, s.table_y - 0.15, 0, side * kPi / 2);
  }
}

/// The same with a corner sofa, whose long end points towards the focal point.
void arrange_corner(Seating& s, const FurnitureShape& corner, double depth) {
  const FurnitureSize f = s.focal->size, sofa = corner.size, t = s.table->size;
  const double least = f.d + 0.8 + sofa.d;
  const double back = depth - least < 1.05 ? depth - 0.02 : std::min(least + 0.5, depth - 1.0);
  const double sofa_y = back - sofa.d / 2;
  s.table_y = back - 0.92 - 0.35 - t.d / 2;
  s.group = {f.w, f.d, 0, {{*s.focal, 0, f.d / 2 + 0.015}, {corner, 0.3, sofa_y, 0, kPi}}};
  if (s.table_y - t.d / 2 > f.d + 0.5) {
    s.group.items.emplace_back(*s.table, 0.75, s.table_y);
  }
}

/// The rug and the things on the table, which is the third item where there was room for one.
void dress_middle(FurnishedRoom& room, const Spot& spot, const Seating& s) {
  const bool round = !room.chance(0.7);
  const FurnitureShape& rug = shape_of("rug", round ? 1 : 0);
  const double wide = room.between(2.2, 2.8);
  const bool has_table = s.group.items.size() > 2;
  room.lay(rug, {round ? 2.0 : wide, round ? 2.0 : 1.8, rug.size.h}, spot.frame,
           has_table ? s.group.items[2].x : 0, s.table_y + 0.1);
  if (!has_table) return;
  GroupItem table = s.group.items[2];
  table.size.w *= 0.8;
  clutter(room, spot.frame, table, "table");
}

void dress_seating(FurnishedRoom& room, const Spot& spot, const Seating& s, bool television) {
  const GroupItem& focal = s.group.items[0];
  const GroupItem& sofa = s.group.items[1];
  if (television) {
    if (s.focal->noun == "tv stand") {
      room.put({shape_of("tv"), 0, focal.y, focal.size.h}, spot.frame);
    }
  } else if (s.focal->noun == "fireplace") {
    GroupItem mantel = focal;
    mantel.size.w *= 0.8;
    mantel.size.d = 0.2;
    mantel.y = 0.16;
    clutter(room, spot.frame, mantel, "living");
    const FurnitureShape& above = room.pick(room.chance(0.5) ? "mirror" : "painting");
    room.hang(above, spot, focal.size.h + 0.4, 0.2);
  }
  const bool corner = sofa.shape->noun == "corner sofa";
  dress_middle(room, spot, s);
  const int cushions = 2 + static_cast<int>(room.rng().below(2));
  for (int i = 0; i < cushions && !corner; ++i) {
    const double x = (sofa.size.w / 2 - 0.42) * (i == 0 ? -1 : i == 1 ? 1 : 0.55);
    const double y = sofa.y - 0.02 + (i == 2 ? 0.02 : 0.04);
    const double turned = kPi + room.between(-0.3, 0.3);
    room.put({shape_of("cushion"), {0.42, 0.15, 0.4}, x, y, 0.45, turned}, spot.frame);
  }
}

std::optional<Spot> place_seating(FurnishedRoom& room, Seating& s) {
  const bool corner = room.area() > 20 && room.chance(0.3);
  const FurnitureShape& loveseat = room.pick("loveseat");
  const FurnitureShape& big = *s.sofa;
  for (int attempt = corner ? 0 : 1; attempt < 5; ++attempt) {
    s.sofa = attempt < 3 ? &big : &loveseat;
    s.chairs = std::array{0, 2, 1, 1, 0}[static_cast<std::size_t>(attempt)];
    // The room's depth from the focal wall decides the spacing: the longer way is tried first.
    const bool along_x_first = room.width() > room.depth();
    for (const bool along_x : {along_x_first, !along_x_first}) {
      const double deep = along_x ? room.width() : room.depth();
      attempt == 0 ? arrange_corner(s, shape_of("corner sofa"), deep) : arrange(s, deep);
      const Score score = [&](const Spot& spot) {
        const bool fits = faces_x(spot.wall) == along_x;
        return (fits ? 0 : -50) - 0.8 * spot.off_centre + 0.1 * std::min(spot.door, 4.0) -
               (spot.window ? 0.8 : 0);
      };
      if (const auto spot = room.place_at_wall(s.group, score)) return spot;
    }
  }
  return std::nullopt;
}

void living_extras(FurnishedRoom& room) {
  const double area = room.area();
  bookshelves(room, area > 28 ? 2 : 1);
  if (area > 14 && room.chance(0.8)) dressed_console(room, room.pick("sideboard"), true);
  if (area > 17) reading_corner(room);
  if (area > 24 && room.chance(0.35)) room.place_at_wall(shape_of("piano"), near_middle, 0.7);
  if (area > 30 && room.chance(0.5)) dressed_console(room, room.pick("display cabinet"), false);
  if (area > 36) {
    const FurnitureShape& table = room.pick("round table");
    table_with_chairs(room, table, table.size, "chair", 0.3 * room.width());
  }
  if (area > 40) {
    dressed_console(room, room.pick("console table"), false);
    reading_corner(room);
  }
  if (room.chance(0.5)) put_in_corner(room, room.pick("ottoman"));
  if (room.chance(0.6)) put_in_corner(room, shape_of("floor lamp", room.rng().below(2)));
  plants(room, area > 20 ? 3 : 2);
  if (room.chance(0.4)) put_in_corner(room, room.pick("basket"));
}

}  // namespace

void furnish_living(FurnishedRoom& room, bool television) {
  const bool curtains = room.chance(0.7);
  if (curtains) dress_windows(room, true);
  Seating s;
  const bool fire = room.area() > 14 && room.chance(television ? 0.25 : 0.7);
  s.focal = &room.pick(fire ? "fireplace" : (television ? "tv stand" : "bookshelf"));
  if (s.focal->size.h > 1.6) s.focal = &shape_of("bookshelf", 1);
  s.sofa = &room.pick("sofa");
  s.table = &room.pick("coffee table");
  s.chair = &room.pick("armchair");
  if (const auto spot = place_seating(room, s)) {
    dress_seating(room, *spot, s, television && !fire);
  } else {
    room.place_at_wall(room.pick(room.narrow() < 2.4 ? "loveseat" : "sofa"), near_middle, 0.6);
    if (television) room.hang_anywhere(shape_of("wall tv"), 1.15);
  }
  living_extras(room);
  if (!curtains) dress_windows(room, false);
  hang_pictures(room, room.area() > 20 ? 4 : 2);
  hang_lights(room, room.chance(0.4) ? Light::kChandelier : Light::kHome);
}

void furnish_dining(FurnishedRoom& room) {
  const bool round = room.narrow() < 2.9 || room.chance(0.2);
  const FurnitureShape& table = room.pick(round ? "round table" : "dining table");
  FurnitureSize size = table.size;
  if (!round && room.area() > 22) size.w += 0.6;
  auto frame = table_with_chairs(room, table, size);
  const FurnitureShape& small = shape_of("kitchen table");
  if (!frame) frame = table_with_chairs(room, small, small.size);
  if (frame) {
    const double half = size.d / 2 + 0.5;
    hang_pendant(room, frame->to_world(0, half));
    if (room.chance(0.6)) {
      room.lay(shape_of("rug"), {size.w + 1.5, size.d + 1.5, 0.012}, *frame, 0, half);
    }
  }
  dressed_console(room, room.pick("sideboard"), true);
  if (room.area() > 12) dressed_console(room, room.pick("display cabinet"), false);
  if (room.area() > 22) dressed_console(room, room.pick("console table"), true);
  if (room.area() > 28) reading_corner(room);
  finish(room, {.plants = 2, .curtains = true, .pictures = 3, .light = Light::kChandelier});
}

void furnish_booth(FurnishedRoom& room) {
  const FurnitureShape& bench = shape_of("bench", 2);
  const FurnitureShape& table = shape_of("kitchen table");
  const double deep = bench.size.d, gap = 0.08, half = table.size.d / 2 + gap + deep / 2;
  const double d = table.size.d + 2 * (deep + gap), y = d / 2;
  const FurnitureGroup group{
      1.3, d, 0, {{table, 0, y}, {bench, 0, y - half}, {bench, 0, y + half, 0, kPi}}};
  const unsigned most = std::max(1U, static_cast<unsigned>(room.area() / 9));
  for (unsigned i = 0; i < most; ++i) {
    const Rect& f = room.space().floor;
    const auto frame = room.place_free(group, {f.x0 + f.width() * (i + 0.5) / most, f.y1, 0});
    if (!frame) break;
    hang_pendant(room, frame->to_world(0, y));
  }
  finish(room, {.plants = 1, .pictures = 3});
}

}  // namespace enfilade::homes::furniture
