#include "enfilade/homes/looks/architecture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <tuple>
#include <utility>

#include "enfilade/homes/plan/draws.h"

namespace enfilade::homes::looks {

Vec3d wall_point(bool along_x, double u, double n, double z) {
  return along_x ? Vec3d{u, n, z} : Vec3d{n, u, z};
}

void wall_box(BuildingSite& site, bool along_x, mesh::MaterialId material, const WallBox& b) {
  site.parts.builder.box(material, wall_point(along_x, b.u0, b.n0, b.z0),
                         wall_point(along_x, b.u1, b.n1, b.z1));
}

void add_obstacle(BuildingSite& site, bool along_x, const WallBox& b) {
  const double u = (b.u0 + b.u1) / 2, n = (b.n0 + b.n1) / 2;
  const double hu = (b.u1 - b.u0) / 2, hn = (b.n1 - b.n0) / 2;
  const Vec3d middle = wall_point(along_x, u, n, 0), half = wall_point(along_x, hu, hn, 0);
  site.parts.obstacles.push_back({middle.x, middle.y, half.x, half.y, 0, b.z0, b.z1});
}

void solid_box(BuildingSite& site, bool along_x, mesh::MaterialId material, const WallBox& box) {
  wall_box(site, along_x, material, box);
  add_obstacle(site, along_x, box);
}

void upright(BuildingSite& site, mesh::MaterialId material, Side facing, double n, double u0,
             double u1, double z0, double z1) {
  if (u1 - u0 < 1e-9 || z1 - z0 < 1e-9) return;
  const bool along_x = runs_along_x(facing);
  // Seen from the front, u grows to the right for +x and -y.
  const bool rising = facing == Side::kPlusX || facing == Side::kMinusY;
  const double a = rising ? u0 : u1, b = rising ? u1 : u0;
  site.parts.builder.quad(material, wall_point(along_x, a, n, z0), wall_point(along_x, b, n, z0),
                          wall_point(along_x, b, n, z1), wall_point(along_x, a, n, z1));
}

void level(BuildingSite& site, mesh::MaterialId material, const Rect& r, double z, bool up) {
  if (r.width() < 1e-9 || r.depth() < 1e-9) return;
  mesh::MeshBuilder& b = site.parts.builder;
  if (up) {
    b.quad(material, {r.x0, r.y0, z}, {r.x1, r.y0, z}, {r.x1, r.y1, z}, {r.x0, r.y1, z});
  } else {
    b.quad(material, {r.x0, r.y1, z}, {r.x1, r.y1, z}, {r.x1, r.y0, z}, {r.x0, r.y0, z});
  }
}

std::vector<Rect> around(const Rect& r, const Rect* hole) {
  if (hole == nullptr) return {r};
  const Rect& h = *hole;
  return {{r.x0, r.y0, h.x0, r.y1},
          {h.x1, r.y0, r.x1, r.y1},
          {h.x0, r.y0, h.x1, h.y0},
          {h.x0, h.y1, h.x1, r.y1}};
}

void add_thing(BuildingSite& site, std::uint32_t object, const char* noun,
               const NamedMaterial& material, std::size_t room, Vec3d a, Vec3d b, double margin) {
  const Vec3d low{std::min(a.x, b.x) - margin, std::min(a.y, b.y) - margin, a.z};
  const Vec3d high{std::max(a.x, b.x) + margin, std::max(a.y, b.y) + margin, b.z};
  site.parts.things.push_back({object, noun, material.colour, material.material, room, low, high});
}

void build_architecture(const Plan& plan, const std::vector<RoomStyle>& styles, HomeParts parts,
                        std::vector<mesh::Portal>& portals) {
  BuildingSite site{plan, styles, parts, portals};
  for (std::size_t r = 0; r < plan.rooms.size(); ++r) build_room(site, r);
  for (const Opening& o : plan.openings) build_opening(site, o);
  for (const Stairs& s : plan.stairs) build_stairs(site, s);
  build_outside(site);
}

std::vector<RoomSpace> room_spaces(const Plan& plan) {
  std::vector<RoomSpace> spaces;
  for (std::size_t r = 0; r < plan.rooms.size(); ++r) {
    const PlanRoom& room = plan.rooms[r];
    RoomSpace space;
    space.room = r;
    space.type = room.type;
    space.floor = room.floor;
    space.floor_z = plan.storeys[room.storey].floor;
    space.ceiling_z = space.floor_z + room.ceiling;
    for (const Opening& o : plan.openings) {
      if (o.room0 != r && o.room1 != r) continue;
      const Side high = o.along_x ? Side::kPlusY : Side::kPlusX;
      const Side wall = o.wall > room.floor.at(high) - 1e-6 ? high : opposite(high);
      space.holes.push_back({wall, o.from, o.to, o.sill, o.head});
      if (o.kind == OpeningKind::kWindow) continue;
      space.keep_clear.push_back(plan::opening_zone(plan, o));
      const bool here = (o.leaf_in_room1 ? o.room1 == r : o.room0 == r);
      if (const auto leaf = plan::leaf_zone(plan, o); leaf && here) {
        space.keep_clear.push_back(*leaf);
      }
    }
    for (const Stairs& s : plan.stairs) {
      if (s.room_below != r && s.room_above != r) continue;
      space.no_way.push_back(s.flight);
      // The flight or its hole, and landings as long as it is wide.
      constexpr double kLanding = 1.0, kBeside = 0.1;
      const bool x = faces_x(s.climbs_towards);
      const double along_x = x ? kLanding : kBeside, along_y = x ? kBeside : kLanding;
      space.keep_clear.push_back({s.flight.x0 - along_x, s.flight.y0 - along_y,
                                  s.flight.x1 + along_x, s.flight.y1 + along_y});
    }
    spaces.push_back(std::move(space));
  }
  return spaces;
}

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

Wall find_wall(const BuildingSite& site, std::size_t room, Side side) {
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
void add_piece(BuildingSite& site, const Wall& w, mesh::MaterialId material, double u0, double u1,
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

void add_skirting(BuildingSite& site, const Wall& w, double u0, double u1) {
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

void build_wall(BuildingSite& site, const Wall& w, mesh::MaterialId material) {
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

void build_floor(BuildingSite& site, std::size_t room) {
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

void build_ceiling(BuildingSite& site, std::size_t room) {
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

void build_room(BuildingSite& site, std::size_t room) {
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

namespace {

constexpr double kGuard = 0.95;      // height of railings, metres
constexpr double kAside = 0.045;     // of a railing from the edge that it guards
constexpr double kHalfRail = 0.025;  // half a handrail's thickness

/// A flight measured from its foot: a along it, c across it.
struct Run {
  bool along_x = true, up = true;
  double foot = 0, length = 0, c0 = 0, c1 = 0;
  double z = 0, height = 0;
  unsigned steps = 1;

  double at(double a) const { return up ? foot + a : foot - a; }
  double going() const { return length / steps; }
  double rise() const { return height / steps; }
  Vec3d point(double a, double c, double up_z) const {
    return wall_point(along_x, at(a), c, z + up_z);
  }
  WallBox box(double a0, double a1, double b0, double b1, double z0, double z1) const {
    return {std::min(at(a0), at(a1)), std::max(at(a0), at(a1)), b0, b1, z + z0, z + z1};
  }
};

Run make_run(const BuildingSite& site, const Stairs& s) {
  Run r;
  r.along_x = faces_x(s.climbs_towards);
  r.up = is_high(s.climbs_towards);
  r.foot = s.flight.at(opposite(s.climbs_towards));
  r.length = s.flight.length(r.along_x);
  std::tie(r.c0, r.c1) = s.flight.range(!r.along_x);
  r.z = site.plan.storeys[s.storey].floor;
  r.height = site.plan.storeys[s.storey].height;
  r.steps = s.steps;
  return r;
}

void build_steps(BuildingSite& site, const Stairs& s, const Run& run) {
  const RoomStyle& style = site.style(s.room_below);
  // Sides and the last riser end 1 mm before walls and the slab, so that no two faces coincide.
  constexpr double kTread = 0.035, kNosing = 0.02, kApart = 0.001, kUnder = 0.14;
  const std::uint32_t object = site.begin("stairs", Mpcat40::kStairs, s.room_below);
  const double c0 = run.c0 + kApart, c1 = run.c1 - kApart;
  for (unsigned k = 0; k < run.steps; ++k) {
    const double a0 = k * run.going(),
                 a1 = (k + 1) * run.going() - (k + 1 == run.steps ? kApart : 0);
    const double top = (k + 1) * run.rise();
    // Flights over other flights are open below.
    const double low = s.storey == 0 ? 0 : std::max(0.0, k * run.rise() - kUnder);
    wall_box(site, run.along_x, style.trim.id,
             run.box(a0, a1, c0 + 0.01, c1 - 0.01, low, top - 0.01));
    wall_box(site, run.along_x, style.wood.id,
             run.box(a0 - kNosing, a1, c0, c1, top - kTread, top));
    add_obstacle(site, run.along_x, run.box(a0 - kNosing, a1, run.c0, run.c1, low, top));
  }
  add_thing(site, object, "stairs", style.wood, s.room_below, run.point(0, run.c0, 0),
            run.point(run.length, run.c1, run.height));
}

// Whether a side of the flight is away from walls.
bool is_free(const BuildingSite& site, const Stairs& s, const Run& run, bool high) {
  constexpr double kAtWall = 0.3;
  const auto [lo, hi] = site.plan.rooms[s.room_below].floor.range(!run.along_x);
  return high ? hi - run.c1 > kAtWall : run.c0 - lo > kAtWall;
}

void add_post(BuildingSite& site, bool along_x, mesh::MaterialId wood, double u, double n,
              double z0, double z1) {
  constexpr double kHalf = 0.035;
  solid_box(site, along_x, wood, {u - kHalf, u + kHalf, n - kHalf, n + kHalf, z0, z1});
}

// The banister along a free side of the flight.
void build_banister(BuildingSite& site, const Stairs& s, const Run& run, double c) {
  const RoomStyle& style = site.style(s.room_below);
  mesh::MeshBuilder& b = site.parts.builder;
  const std::uint32_t object = site.begin("banister", Mpcat40::kRailing, s.room_below);
  const double g = run.going(), r = run.rise();
  for (unsigned k = 0; k < run.steps; ++k) {
    const double a = (k + 0.5) * g, top = (k + 1) * r;
    b.bar(style.metal.id, run.point(a, c, top - 0.01), run.point(a, c, top + kGuard - r / 2), 0.011,
          6);
    add_obstacle(
        site, run.along_x,
        run.box(k * g, (k + 1) * g, c - kHalfRail, c + kHalfRail, top, top + kGuard + r / 2));
  }
  b.bar(style.wood.id, run.point(0, c, r / 2 + kGuard),
        run.point(run.length, c, run.height + r / 2 + kGuard - r), kHalfRail);
  const double z1 = run.z + r + kGuard + 0.05;
  add_post(site, run.along_x, style.wood.id, run.at(0.04), c, run.z + r - 0.01, z1);
  add_thing(site, object, "banister", style.wood, s.room_below, run.point(0, c, 0),
            run.point(run.length, c, run.height + kGuard), kHalfRail);
}

// A level railing on the floor above, from one point to another along an axis.
void build_guard(BuildingSite& site, std::size_t room, bool along_x, double u0, double u1,
                 double n) {
  const RoomStyle& style = site.style(room);
  mesh::MeshBuilder& b = site.parts.builder;
  const double z = site.floor_z(room);
  const std::uint32_t object = site.begin("railing", Mpcat40::kRailing, room);
  const int gaps = std::max(1, static_cast<int>(std::ceil((u1 - u0) / 0.13)));
  for (int i = 1; i < gaps; ++i) {
    const double u = u0 + (u1 - u0) * i / gaps;
    b.bar(style.metal.id, wall_point(along_x, u, n, z - 0.01),
          wall_point(along_x, u, n, z + kGuard), 0.011, 6);
  }
  wall_box(site, along_x, style.wood.id,
           {u0, u1, n - kHalfRail, n + kHalfRail, z + kGuard - 0.02, z + kGuard + 0.03});
  add_obstacle(site, along_x, {u0, u1, n - kHalfRail, n + kHalfRail, z, z + kGuard + 0.03});
  add_post(site, along_x, style.wood.id, u0, n, z, z + kGuard + 0.06);
  add_post(site, along_x, style.wood.id, u1, n, z, z + kGuard + 0.06);
  add_thing(site, object, "railing", style.wood, room, wall_point(along_x, u0, n - kHalfRail, z),
            wall_point(along_x, u1, n + kHalfRail, z + kGuard));
}

void build_guards(BuildingSite& site, const Stairs& s, const Run& run) {
  // Where another flight begins above this one's foot, its steps close that end.
  const bool stacked = std::any_of(site.plan.stairs.begin(), site.plan.stairs.end(),
                                   [&](const Stairs& t) { return t.storey == s.storey + 1; });
  double c0 = run.c0 + 0.04, c1 = run.c1 - 0.04;
  for (const bool high : {false, true}) {
    if (!is_free(site, s, run, high)) continue;
    const double c = high ? run.c1 + kAside : run.c0 - kAside;
    (high ? c1 : c0) = c;
    const double a0 = stacked ? 0.05 : -kAside, a1 = run.length - 0.04;
    build_guard(site, s.room_above, run.along_x, std::min(run.at(a0), run.at(a1)),
                std::max(run.at(a0), run.at(a1)), c);
  }
  if (!stacked) build_guard(site, s.room_above, !run.along_x, c0, c1, run.at(-kAside));
}

}  // namespace

void build_stairs(BuildingSite& site, const Stairs& stairs) {
  const Run run = make_run(site, stairs);
  build_steps(site, stairs, run);
  if (is_free(site, stairs, run, false)) build_banister(site, stairs, run, run.c0 + kAside);
  if (is_free(site, stairs, run, true)) build_banister(site, stairs, run, run.c1 - kAside);
  build_guards(site, stairs, run);
}

}  // namespace enfilade::homes::looks
