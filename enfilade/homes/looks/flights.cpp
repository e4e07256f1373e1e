#include <algorithm>
#include <cmath>
#include <tuple>

#include "enfilade/homes/looks/site.h"

namespace enfilade::homes::looks {
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

Run make_run(const Site& site, const Stairs& s) {
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

void build_steps(Site& site, const Stairs& s, const Run& run) {
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
bool is_free(const Site& site, const Stairs& s, const Run& run, bool high) {
  constexpr double kAtWall = 0.3;
  const auto [lo, hi] = site.plan.rooms[s.room_below].floor.range(!run.along_x);
  return high ? hi - run.c1 > kAtWall : run.c0 - lo > kAtWall;
}

void add_post(Site& site, bool along_x, mesh::MaterialId wood, double u, double n, double z0,
              double z1) {
  constexpr double kHalf = 0.035;
  solid_box(site, along_x, wood, {u - kHalf, u + kHalf, n - kHalf, n + kHalf, z0, z1});
}

// The banister along a free side of the flight.
void build_banister(Site& site, const Stairs& s, const Run& run, double c) {
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
void build_guard(Site& site, std::size_t room, bool along_x, double u0, double u1, double n) {
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

void build_guards(Site& site, const Stairs& s, const Run& run) {
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

void build_stairs(Site& site, const Stairs& stairs) {
  const Run run = make_run(site, stairs);
  build_steps(site, stairs, run);
  if (is_free(site, stairs, run, false)) build_banister(site, stairs, run, run.c0 + kAside);
  if (is_free(site, stairs, run, true)) build_banister(site, stairs, run, run.c1 - kAside);
  build_guards(site, stairs, run);
}

}  // namespace enfilade::homes::looks
