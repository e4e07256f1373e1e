#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>

#include "enfilade/homes/looks/site.h"
#include "enfilade/homes/plan/model.h"

namespace enfilade::homes::looks {
namespace {

constexpr double kSkirting = 0.08, kSkirtingDepth = 0.012, kSkirtingInWall = 0.01;  // metres

/// A wall of a room, from inside.
struct Wall {
  std::size_t room = 0;
  Side side = Side::kPlusX;  // of the room's floor
  bool along_x = false, outer = false;
  double n = 0, u0 = 0, u1 = 0;       // its face and its ends
  std::vector<const Opening*> holes;  // in order
};

Wall find_wall(const Site& site, std::size_t room, Side side) {
  const Plan& plan = site.plan;
  const Rect& f = plan.rooms[room].floor;
  Wall w;
  w.room = room;
  w.side = side;
  w.along_x = runs_along_x(side);
  w.n = f.at(side);
  std::tie(w.u0, w.u1) = f.range(w.along_x);
  w.outer = std::abs(plan.outline.at(side) - w.n) < plan.outer_wall + 1e-6;
  for (const Opening& o : plan.openings) {
    if ((o.room0 != room && o.room1 != room) || o.along_x != w.along_x) continue;
    if (std::abs(o.wall - w.n) < plan.outer_wall) w.holes.push_back(&o);
  }
  std::sort(w.holes.begin(), w.holes.end(),
            [](const Opening* a, const Opening* b) { return a->from < b->from; });
  return w;
}

// A piece of a wall without holes: its face and its obstacle.
void add_piece(Site& site, const Wall& w, mesh::MaterialId material, double u0, double u1,
               double z0, double z1) {
  const double z = site.floor_z(w.room);
  upright(site, material, opposite(w.side), w.n, u0, u1, z + z0, z + z1);
  const double depth = w.outer ? site.plan.outer_wall : site.plan.inner_wall / 2;
  const bool high = is_high(w.side);
  // Obstacles reach round the room's corners; those at holes end there.
  const double past = site.plan.inner_wall / 2;
  const double a = u0 <= w.u0 ? u0 - past : u0, b = u1 >= w.u1 ? u1 + past : u1;
  add_obstacle(site, w.along_x,
               {a, b, high ? w.n : w.n - depth, high ? w.n + depth : w.n, z + z0, z + z1});
}

void add_skirting(Site& site, const Wall& w, double u0, double u1) {
  if (u1 - u0 < 0.03) return;
  const double z = site.floor_z(w.room);
  const bool high = is_high(w.side);
  // Where two meet in a corner, one ends at the other.
  const double cut = w.along_x ? 0 : kSkirtingDepth;
  const double a = u0 <= w.u0 ? u0 + cut : u0, b = u1 >= w.u1 ? u1 - cut : u1;
  const double n0 = high ? w.n - kSkirtingDepth : w.n - kSkirtingInWall;
  const double n1 = high ? w.n + kSkirtingInWall : w.n + kSkirtingDepth;
  site.parts.builder.box(site.style(w.room).trim.id, wall_point(w.along_x, a, n0, z),
                         wall_point(w.along_x, b, n1, z + kSkirting), false);
  add_obstacle(site, w.along_x, {a, b, n0, n1, z, z + kSkirting});
}

void build_wall(Site& site, const Wall& w, mesh::MaterialId material) {
  site.begin("wall", Mpcat40::kWall, w.room);
  const double top = site.plan.rooms[w.room].ceiling;
  double at = w.u0, skirting = w.u0;
  for (const Opening* o : w.holes) {
    add_piece(site, w, material, at, o->from, 0, top);
    if (o->sill > 0) add_piece(site, w, material, o->from, o->to, 0, o->sill);
    add_piece(site, w, material, o->from, o->to, o->head, top);
    at = o->to;
    if (o->sill > 0) continue;
    add_skirting(site, w, skirting, o->from - kCasing);
    skirting = o->to + kCasing;
  }
  add_piece(site, w, material, at, w.u1, 0, top);
  add_skirting(site, w, skirting, w.u1);
}

// The wall that may have a material of its own: the longest without doors.
Side feature_side(const std::array<Wall, 4>& walls) {
  Side best = Side::kPlusX;
  double most = -1;
  for (const Wall& w : walls) {
    const bool door =
        std::any_of(w.holes.begin(), w.holes.end(), [](const Opening* o) { return o->sill == 0; });
    const double value = w.u1 - w.u0 - (door ? 4 : 0) - 0.5 * static_cast<double>(w.holes.size());
    if (value > most) {
      most = value;
      best = w.side;
    }
  }
  return best;
}

const Rect* flight_hole(const Plan& plan, std::size_t room, bool above) {
  for (const Stairs& s : plan.stairs) {
    if ((above ? s.room_below : s.room_above) == room) return &s.flight;
  }
  return nullptr;
}

void build_floor(Site& site, std::size_t room) {
  const RoomStyle& style = site.style(room);
  const double z = site.floor_z(room);
  site.begin("floor", Mpcat40::kFloor, room);
  for (const Rect& r : around(site.plan.rooms[room].floor, flight_hole(site.plan, room, false))) {
    level(site, style.floor.id, r, z, true);
  }
  for (const Opening& o : site.plan.openings) {
    if (o.room0 != room || o.sill > 0) continue;
    // Thresholds: through the wall, or up to a closed front door.
    const double half = (o.room1 ? site.plan.inner_wall : site.plan.outer_wall) / 2;
    level(site, style.floor.id, plan::both_sides(o.along_x, o.wall, o.from, o.to, half), z, true);
  }
}

void build_ceiling(Site& site, std::size_t room) {
  const Rect& floor = site.plan.rooms[room].floor;
  const double z = site.floor_z(room) + site.plan.rooms[room].ceiling;
  const double top = site.floor_z(room) + site.plan.storeys[site.plan.rooms[room].storey].height;
  const Rect* hole = flight_hole(site.plan, room, true);
  site.begin("ceiling", Mpcat40::kCeiling, room);
  for (const Rect& r : around(floor, hole)) {
    level(site, site.style(room).ceiling.id, r, z, false);
    if (r.width() <= 0 || r.depth() <= 0) continue;
    add_obstacle(site, true, {r.x0, r.x1, r.y0, r.y1, z, top - 0.01});
  }
  if (hole == nullptr) return;
  // The edges of the slab that the stairs lead through.
  site.begin("wall", Mpcat40::kWall, room);
  const mesh::MaterialId paint = site.style(room).ceiling.id;
  for (const Side side : {Side::kPlusX, Side::kMinusX, Side::kPlusY, Side::kMinusY}) {
    const auto [u0, u1] = hole->range(runs_along_x(side));
    upright(site, paint, opposite(side), hole->at(side), u0, u1, z, top);
  }
}

}  // namespace

void build_room(Site& site, std::size_t room) {
  std::array<Wall, 4> walls;
  std::ranges::transform(kSides, walls.begin(),
                         [&](Side side) { return find_wall(site, room, side); });
  const Side feature = feature_side(walls);
  for (const Wall& w : walls) {
    const RoomStyle& style = site.style(room);
    build_wall(site, w, w.side == feature ? style.feature_wall.id : style.wall.id);
  }
  build_floor(site, room);
  build_ceiling(site, room);
}

}  // namespace enfilade::homes::looks
