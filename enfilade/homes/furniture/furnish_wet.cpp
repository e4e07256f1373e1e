#include <algorithm>
#include <cmath>

#include "enfilade/homes/furniture/furnish_room.h"

namespace enfilade::homes::furniture {
namespace {

constexpr double kCounterDeep = 0.62, kCounterTop = 0.92, kUnit = 0.6;

/// A run of kitchen units along a wall, from left to right as seen from the room.
struct Run {
  FurnitureGroup group;
  double at = 0;      ///< where the next unit begins
  double sink = 0;    ///< middle of the sink's cabinet
  double stove = -9;  ///< middle of the stove; -9: none
  double fridge = 0;  ///< width of the tall unit at the left end
};

void add_unit(Run& run, const FurnitureShape& shape, FurnitureSize size) {
  run.group.items.emplace_back(shape, size, run.at + size.w / 2, size.d / 2 + 0.012);
  run.at += size.w;
}

/// Worktops where there is no stove and nothing tall.
void add_tops(Run& run, double from, double to) {
  if (to - from < 0.2) return;
  const bool sink = run.sink > from && run.sink < to;
  const auto add = [&](double a, double b, std::size_t variant) {
    if (b - a < 0.02) return;
    const FurnitureSize size{b - a, kCounterDeep, 0.14};
    run.group.items.emplace_back(shape_of("countertop", variant), size, (a + b) / 2,
                                 size.d / 2 + 0.012, kCounterTop - 0.04);
  };
  if (!sink) return add(from, to, 1);
  add(from, run.sink - 0.3, 1);
  add(run.sink - 0.3, run.sink + 0.3, 2);
  add(run.sink + 0.3, to, 1);
}

void add_units(FurnishedRoom& room, Run& run, int units, double each, int sink, int hot) {
  const FurnitureSize usual{each, 0.6, kCounterTop - 0.04};
  for (int i = 0; i < units; ++i) {
    if (i == sink) {
      run.sink = run.at + each / 2;
      add_unit(run, shape_of("sink cabinet"), usual);
    } else if (i == hot) {
      run.stove = run.at + each / 2;
      const FurnitureShape& shape = room.pick("stove");
      add_unit(run, shape, {each, shape.size.d, shape.size.h});
    } else if (i == sink + 1 && units > 4) {
      add_unit(run, shape_of("dishwasher"), usual);
    } else {
      add_unit(run, room.pick("kitchen cabinet"), usual);
    }
  }
}

/// Moves the origin from the left end to the middle.
void centre(Run& run, double deep, double front) {
  for (GroupItem& item : run.group.items) item.x -= run.at / 2;
  run.sink -= run.at / 2;
  run.stove -= run.at / 2;
  run.group.w = run.at;
  run.group.d = deep;
  run.group.front = front;
}

/// A run of `length` metres with its sink as near as possible to `sink_at` (from the left end).
Run make_run(FurnishedRoom& room, double length, bool fridge, bool stove, double sink_at) {
  Run run;
  if (fridge) {
    const FurnitureShape& shape =
        length > 3.2 ? room.pick("refrigerator") : shape_of("refrigerator");
    add_unit(run, shape, shape.size);
    run.fridge = run.at;
  }
  const double rest = length - run.fridge - 0.02;
  const int units = std::max(1, static_cast<int>(rest / kUnit));
  const double each = std::min(rest / units, 0.8);
  const int sink = std::clamp(static_cast<int>((sink_at - run.fridge) / each), 0, units - 1);
  const int hot = units < 3 || !stove ? -1 : (sink + 2 < units ? sink + 2 : std::max(0, sink - 2));
  const double first = run.at;
  add_units(room, run, units, each, sink, hot);
  if (run.stove > 0) {
    add_tops(run, first, run.stove - each / 2);
    add_tops(run, run.stove + each / 2, run.at);
  } else {
    add_tops(run, first, run.at);
  }
  const FurnitureShape& basin = shape_of("kitchen sink");
  const double low = kCounterTop - (basin.size.h - 0.3);
  run.group.items.emplace_back(basin, run.sink, kCounterDeep / 2 + 0.012, low);
  centre(run, 0.7, 0.75);
  return run;
}

/// A hood above the stove, cabinets beside it.
void hang_above_run(FurnishedRoom& room, const Run& run, const Spot& spot) {
  const double low = 1.45;
  const FurnitureShape& hood = room.pick("range hood");
  const bool has_stove = run.stove > -run.at / 2;
  // Frames look into the room: the wall's own coordinate runs along or against x.
  const auto along = [&](double x) {
    const Vec3d p = spot.frame.to_world(x, 0);
    return faces_x(spot.wall) ? p.y : p.x;
  };
  if (has_stove) {
    const FurnitureSize size{0.6, 0.48, std::min(0.75, room.height() - 1.7)};
    room.hang(hood, size, spot.wall, along(run.stove), 1.6);
  }
  const FurnitureShape& cabinet = shape_of("wall cabinet");
  const FurnitureShape& open = shape_of("wall cabinet", 1);
  for (double x = -run.at / 2 + run.fridge + kUnit / 2; x < run.at / 2 - 0.2; x += kUnit) {
    if (has_stove && std::abs(x - run.stove) < 0.3 + kUnit / 2 + 0.05) continue;
    const FurnitureShape& shape = room.chance(0.25) ? open : cabinet;
    const double h = std::min(0.72, room.height() - low - 0.12);
    // Wall items keep 6 cm apart: cabinets are a little less wide than their place.
    room.hang(shape, {kUnit - 0.062, shape.size.d, h}, spot.wall, along(x), low);
  }
}

void dress_run(FurnishedRoom& room, const Run& run, const Spot& spot) {
  hang_above_run(room, run, spot);
  for (const GroupItem& item : run.group.items) {
    if (item.shape->noun != "countertop" || item.size.w < 0.35) continue;
    if (std::abs(item.x - run.sink) < 0.2) continue;
    GroupItem top = item;
    top.size.h = 0.04;
    clutter(room, spot.frame, top, "kitchen");
  }
}

std::optional<Spot> place_run(FurnishedRoom& room, Run& run) {
  const double longest = room.longest();
  const double usual = std::min(longest - 0.1, 2.4 + 0.09 * room.area());
  const Score score = [](const Spot& s) {
    return (s.window ? 0.8 : 0.0) + (s.corner < 0.15 ? 0.4 : 0.0) + 0.1 * std::min(s.door, 4.0);
  };
  for (const double length : {usual, 0.85 * usual, 0.7 * usual, 2.4, 1.8, 1.2}) {
    if (length > longest) continue;
    run = make_run(room, length, length > 1.75, length > 2.2, 0.55 * length);
    // The refrigerator would cover a window; without it the run may fit below one.
    if (const auto spot = room.place_at_wall(run.group, score)) return spot;
    run = make_run(room, length - 0.6, false, length > 2.2, 0.5 * (length - 0.6));
    if (const auto spot = room.place_at_wall(run.group, score)) {
      room.place_at_wall(room.pick("refrigerator"), in_corner, 0.6);
      return spot;
    }
  }
  return std::nullopt;
}

void second_run(FurnishedRoom& room, double length) {
  Run run;
  const int units = std::max(1, static_cast<int>(length / kUnit));
  for (int i = 0; i < units; ++i) add_unit(run, room.pick("kitchen cabinet"), {kUnit, 0.6, 0.88});
  run.sink = -9;
  add_tops(run, 0, run.at);
  centre(run, 0.66, 0.6);
  if (const auto spot = room.place_at_wall(run.group, in_corner)) dress_run(room, run, *spot);
}

bool place_island(FurnishedRoom& room) {
  const FurnitureShape& island = room.pick("kitchen island");
  const FurnitureShape& stool = room.pick("bar stool");
  const auto [w, d, h] = island.size;
  const GroupItem top(island, 0, stool.size.d + 0.05 + d / 2);
  FurnitureGroup group{w, d + stool.size.d + 0.05, 0, {top}};
  for (const double x : {-0.28, 0.28}) group.items.emplace_back(stool, x * w, stool.size.d / 2);
  const auto frame = room.place_free(group, room.middle().origin);
  if (!frame) return false;
  clutter(room, *frame, top, "kitchen");
  hang_pendant(room, frame->to_world(0, top.y));
  return true;
}

}  // namespace

void furnish_kitchen(FurnishedRoom& room) {
  Run run;
  if (const auto spot = place_run(room, run)) dress_run(room, run, *spot);
  if (room.area() > 9) second_run(room, std::min(2.4, 0.12 * room.area()));
  const bool island = room.narrow() > 3.4 && room.chance(0.6) && place_island(room);
  if (!island || room.area() > 24) {
    const FurnitureShape& table = room.pick("kitchen table");
    table_with_chairs(room, table, table.size);
  }
  if (room.area() > 14) dressed_console(room, room.pick("cupboard"), false);
  put_in_corner(room, shape_of("trash can", 1));
  if (room.area() > 9) plants(room, 1);
  dress_windows(room, false);
  room.hang_anywhere(room.pick("clock"), 1.75);
  hang_pictures(room, 1);
  hang_lights(room, Light::kSpots);
}

namespace {

void hang_mirror(FurnishedRoom& room, const Spot& spot, double low) {
  const FurnitureShape& mirror =
      room.chance(0.25) ? shape_of("medicine cabinet") : room.pick("mirror");
  if (!room.hang(mirror, spot, low, 0.15)) return;
  const double high = low + mirror.size.h + 0.09;
  room.hang(room.pick("wall lamp"), spot, std::min(high, room.height() - 0.4), 0.1);
}

/// A sink, on a cabinet if `large`, with a mirror and a lamp above.
void wash_place(FurnishedRoom& room, bool large) {
  const Score score = [](const Spot& s) {
    return -0.3 * s.off_centre + 0.05 * s.door - (s.window ? 0.7 : 0);
  };
  std::optional<Spot> spot;
  double top = 0.85;
  FurnitureGroup group;
  if (large) {
    const FurnitureShape& cabinet = room.pick("bathroom cabinet");
    const FurnitureShape& bowl = shape_of("washbasin");
    const bool two = room.area() > 9;
    FurnitureSize size = cabinet.size;
    if (two) size.w = 1.4;
    const double y = size.d / 2 + 0.012;
    group = {size.w, size.d + 0.02, 0.5, {{cabinet, size, 0, y}}};
    for (const double x : two ? std::vector{-0.35, 0.35} : std::vector{0.0}) {
      group.items.emplace_back(bowl, x, y, size.h);
    }
    spot = room.place_at_wall(group, score);
    top = 1.0;
  }
  if (!spot) {
    const FurnitureShape& sink = room.pick("sink");
    const auto [w, d, h] = sink.size;
    group = {w, d + 0.02, 0.4, {{sink, 0, d / 2 + 0.012}}};
    spot = room.place_at_wall(group, score);
  }
  if (!spot) return;
  hang_mirror(room, *spot, top + 0.2);
  if (large && group.items.size() == 2) {
    GroupItem side = group.items[0];
    side.size.w = 0.2;
    side.x = 0.3;
    clutter(room, spot->frame, side, "bath");
  }
}

void place_toilet(FurnishedRoom& room) {
  const FurnitureShape& toilet = room.pick("toilet");
  const Score score = [](const Spot& s) { return -0.4 * std::min(s.corner, 1.5) + 0.15 * s.door; };
  const auto spot = room.place_at_wall(toilet, score, 0.4);
  if (!spot) {
    room.place_at_wall(shape_of("toilet", 1), away_from_doors, 0.2);
    return;
  }
  const FurnitureShape& paper = shape_of("toilet paper");
  room.hang(paper, paper.size, spot->wall, spot->along + 0.36, 0.65, 0.1);
  put_in_corner(room, shape_of("toilet brush"));
}

/// A shower or a bathtub with a mat in front of it. False if it does not fit.
bool place_bathing(FurnishedRoom& room, std::string_view noun) {
  const FurnitureShape& shape = room.pick(noun);
  if (shape.size.h > room.height()) return false;
  const Score score = [&](const Spot& s) {
    return in_corner(s) + 0.1 * s.door + (s.window && noun == "bathtub" ? 0.3 : 0);
  };
  const auto spot = room.place_at_wall(shape, score, 0.5);
  if (!spot) return false;
  const FurnitureShape& mat = shape_of("bath mat");
  room.lay(mat, mat.size, spot->frame, 0, shape.size.d + 0.32);
  return true;
}

void bath_extras(FurnishedRoom& room) {
  const unsigned towels = room.area() > 6 ? 2 : 1;
  for (unsigned i = 0; i < towels; ++i) {
    const FurnitureShape& towel = shape_of("towel", room.rng().below(3));
    const auto [w, d, h] = towel.size;
    const GroupItem item(towel, 0, d / 2 + 0.002, h > 1 ? 0.5 : 0.75);
    room.place_at_wall({w, d, 0, {item}}, near_middle);
  }
  if (room.chance(0.6)) put_in_corner(room, shape_of("trash can"));
  if (room.chance(0.5)) put_in_corner(room, room.pick("basket"));
  if (room.chance(0.4)) {
    const FurnitureShape& robe = shape_of("bathrobe");
    const auto [w, d, h] = robe.size;
    room.place_at_wall({w, d, 0, {{robe, 0, d / 2 + 0.01, 0.7}}}, near_middle);
  }
  if (room.area() > 6) plants(room, 1);
  if (room.area() > 10) room.place_at_wall(room.pick("stool"), in_corner, 0);
  if (room.chance(0.4)) room.place_at_wall(shape_of("radiator"), near_middle, 0);
}

}  // namespace

void furnish_bath(FurnishedRoom& room) {
  const bool tub = room.area() > 4.2 && room.chance(0.7) && place_bathing(room, "bathtub");
  if (!tub || room.area() > 7.5) place_bathing(room, "shower");
  wash_place(room, room.area() > 3.6);
  place_toilet(room);
  if (room.area() > 8 && room.chance(0.5)) {
    room.place_at_wall(shape_of("bidet"), away_from_doors, 0.4);
  }
  bath_extras(room);
  finish(room, {.pictures = room.area() > 7 ? 1U : 0U, .light = Light::kSpots});
}

void furnish_toilet(FurnishedRoom& room) {
  place_toilet(room);
  wash_place(room, false);
  if (room.area() > 2) put_in_corner(room, shape_of("trash can"));
  const FurnitureShape& towel = shape_of("towel");
  room.hang(towel, towel.size, kSides[room.rng().below(4)], room.middle().origin.x, 0.8, 0.6);
  finish(room, {.pictures = 1});
}

void furnish_spa(FurnishedRoom& room) {
  place_bathing(room, "bathtub");
  place_bathing(room, "shower");
  for (int i = 0; i < 3; ++i) room.place_at_wall(room.pick("bench"), near_middle, 0.4);
  wash_place(room, true);
  bath_extras(room);
  finish(room, {.plants = 3, .light = Light::kSpots});
}

void furnish_laundry(FurnishedRoom& room) {
  const FurnitureShape& washer = shape_of("washing machine");
  const FurnitureShape& dryer = shape_of("clothes dryer");
  const FurnitureGroup pair{1.24, 0.66, 0.5, {{washer, -0.31, 0.33}, {dryer, 0.31, 0.33}}};
  if (const auto spot = room.place_at_wall(pair, near_middle)) {
    GroupItem top = pair.items[0];
    top.x = 0;
    top.size.w = 1.2;
    clutter(room, spot->frame, top, "store");
    room.hang(room.pick("shelf"), *spot, 1.5, 0.3);
  } else {
    room.place_at_wall(washer, away_from_doors, 0.4);
  }
  room.place_at_wall(shape_of("utility sink"), away_from_doors, 0.4);
  room.place_at_wall(room.pick("storage shelf"), in_corner, 0.4);
  put_in_corner(room, room.pick("basket"));
  if (room.area() > 6) coat_hooks(room);
  if (room.area() > 8) room.place_at_wall(room.pick("cupboard"), in_corner, 0.5);
  finish(room, {});
}

}  // namespace enfilade::homes::furniture
