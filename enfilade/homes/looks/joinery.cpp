#include <algorithm>
#include <cmath>
#include <numbers>

#include "enfilade/homes/looks/architecture.h"
#include "enfilade/homes/plan/draws.h"

namespace enfilade::homes::looks {
namespace {

constexpr double kLining = 0.03;    // of a frame within its hole, metres
constexpr double kProud = 0.014;    // of linings and casings, before the wall
constexpr double kEmbedded = 0.01;  // of what is fixed to a wall, into it
constexpr double kLeafThick = 0.04;

// The lining of a hole, and casings around it on both of the wall's faces.
void build_frame(BuildingSite& site, const Opening& o, mesh::MaterialId trim, double z) {
  const double half = plan::wall_thickness(site.plan, o) / 2;
  const double n0 = o.wall - half - kProud, n1 = o.wall + half + kProud;
  const double top = z + o.head;
  solid_box(site, o.along_x, trim, {o.from, o.from + kLining, n0, n1, z, top});
  solid_box(site, o.along_x, trim, {o.to - kLining, o.to, n0, n1, z, top});
  solid_box(site, o.along_x, trim, {o.from + kLining, o.to - kLining, n0, n1, top - kLining, top});
  for (const int side : {-1, 1}) {
    const double a = o.wall + side * (half - kEmbedded),
                 b = o.wall + side * (half + kProud - 0.003);
    const double m0 = std::min(a, b), m1 = std::max(a, b);
    solid_box(site, o.along_x, trim, {o.from - kCasing, o.from, m0, m1, z, top + kCasing});
    solid_box(site, o.along_x, trim, {o.to, o.to + kCasing, m0, m1, z, top + kCasing});
    solid_box(site, o.along_x, trim, {o.from, o.to, m0, m1, top, top + kCasing});
  }
}

// A leaf with two panels and handles; local x along it from its hinges, y through it.
void build_leaf(BuildingSite& site, double width, double height, double y0, mesh::MaterialId wood,
                mesh::MaterialId metal) {
  mesh::MeshBuilder& b = site.parts.builder;
  const double y1 = y0 + kLeafThick;
  constexpr double kFoot = 0.01, kPanel = 0.006, kRim = 0.12;
  b.box(wood, {0, y0, kFoot}, {width, y1, height});
  const double middle = 0.95;
  for (const auto& [z0, z1] :
       {std::pair{0.2, middle - 0.06}, std::pair{middle + 0.1, height - kRim}}) {
    b.box(wood, {kRim, y0 - kPanel, z0}, {width - kRim, y1 + kPanel, z1});
  }
  constexpr double kHandle = 0.05, kRadius = 0.009;
  for (const double y : {y0 - kHandle, y1 + kHandle}) {
    b.bar(metal, {width - 0.06, (y0 + y1) / 2, middle}, {width - 0.06, y, middle}, kRadius);
    b.bar(metal, {width - 0.052, y, middle}, {width - 0.18, y, middle}, kRadius);
  }
}

// Obstacles of a leaf as it stands, with its handles.
void add_leaf_obstacles(BuildingSite& site, const mesh::Placement& at, double width, double height,
                        double y0) {
  const auto add = [&](double x0, double x1, double ya, double yb, double z0, double z1) {
    const Vec3d m = at.to_world({(x0 + x1) / 2, (ya + yb) / 2, 0});
    site.parts.obstacles.push_back({m.x, m.y, (x1 - x0) / 2, (yb - ya) / 2, at.turned,
                                    at.position.z + z0, at.position.z + z1});
  };
  add(0, width, y0 - 0.006, y0 + kLeafThick + 0.006, 0, height);
  add(width - 0.19, width - 0.05, y0 - 0.06, y0 + kLeafThick + 0.06, 0.94, 0.96);
}

void build_open_leaf(BuildingSite& site, const Opening& o, double z) {
  const std::size_t room = o.leaf_in_room1 ? *o.room1 : o.room0;
  const RoomStyle& style = site.style(room);
  const double half = plan::wall_thickness(site.plan, o) / 2;
  const double into = o.leaf_in_room1 ? 1 : -1, closed = o.hinge_at_to ? -1 : 1;
  const double hinge = o.hinge_at_to ? o.to - kLining : o.from + kLining;
  const double angle = o.leaf * std::numbers::pi / 180;
  const double du = closed * std::cos(angle), dn = into * std::sin(angle);
  const Vec3d direction = wall_point(o.along_x, du, dn, 0);
  const Vec3d away = wall_point(o.along_x, -closed, 0, 0);  // from the passage
  const mesh::Placement at{wall_point(o.along_x, hinge, o.wall + into * (half + kProud + 0.006), z),
                           std::atan2(direction.y, direction.x)};
  const double left = -direction.y * away.x + direction.x * away.y;
  const double y0 = left > 0 ? 0 : -kLeafThick;
  const double width = o.to - o.from - 2 * kLining - 0.004, height = o.head - kLining - 0.004;
  const std::uint32_t leaf = site.begin("door", Mpcat40::kDoor, room, at);
  build_leaf(site, width, height, y0, style.trim.id, style.metal.id);
  add_leaf_obstacles(site, at, width, height, y0);
  const Vec3d end = at.to_world({width, 0, height});
  add_thing(site, leaf, "door", style.trim, room, at.position, end, kLeafThick);
}

void build_doorway(BuildingSite& site, const Opening& o) {
  const bool arch = o.kind == OpeningKind::kArch;
  const RoomStyle& style = site.style(o.room0);
  const double z = site.floor_z(o.room0), half = plan::wall_thickness(site.plan, o) / 2;
  const char* name = arch ? "archway" : "door frame";
  const std::uint32_t object = site.begin(name, Mpcat40::kDoor, o.room0);
  build_frame(site, o, style.trim.id, z);
  if (arch || o.leaf <= 0) {
    add_thing(site, object, arch ? "archway" : "doorway", style.trim, o.room0,
              wall_point(o.along_x, o.from, o.wall - half, z),
              wall_point(o.along_x, o.to, o.wall + half, z + o.head));
  }
  if (!arch && o.leaf > 0) build_open_leaf(site, o, z);
}

void build_entrance(BuildingSite& site, const Opening& o) {
  const bool garage = site.plan.rooms[o.room0].type == 'g';
  const RoomStyle& style = site.style(o.room0);
  const double z = site.floor_z(o.room0);
  const NamedMaterial& face = garage ? style.white : style.wood;
  const char* name = garage ? "garage door" : "front door";
  site.begin("door frame", Mpcat40::kDoor, o.room0);
  build_frame(site, o, style.trim.id, z);
  const double u0 = o.from + kLining, u1 = o.to - kLining, top = o.head - kLining;
  const mesh::Placement at{wall_point(o.along_x, o.along_x ? u0 : u1, o.wall, z),
                           o.along_x ? 0 : -std::numbers::pi / 2};
  const std::uint32_t door = site.begin(name, Mpcat40::kDoor, o.room0, at);
  const double width = u1 - u0;
  if (garage) {
    constexpr int kSlats = 4;
    site.parts.builder.box(face.id, {0, -0.02, 0}, {width, 0.02, top});
    for (int i = 0; i < kSlats; ++i) {
      site.parts.builder.box(face.id, {0.03, -0.035, top * i / kSlats + 0.02},
                             {width - 0.03, 0.035, top * (i + 1) / kSlats - 0.02});
    }
  } else {
    build_leaf(site, width, top, -kLeafThick / 2, face.id, style.metal.id);
  }
  const double half = plan::wall_thickness(site.plan, o) / 2;
  add_obstacle(site, o.along_x, {o.from, o.to, o.wall - 0.05, o.wall + half, z, z + o.head});
  add_thing(site, door, name, face, o.room0, wall_point(o.along_x, u0, o.wall - 0.05, z),
            wall_point(o.along_x, u1, o.wall + 0.05, z + top));
}

// The sides of a hole through an outer wall.
void build_reveals(BuildingSite& site, const Opening& o, mesh::MaterialId paint, double z) {
  const double half = plan::wall_thickness(site.plan, o) / 2;
  const double n0 = o.wall - half, n1 = o.wall + half, z0 = z + o.sill, z1 = z + o.head;
  const Side along = o.along_x ? Side::kPlusX : Side::kPlusY;  // the direction that u grows in
  upright(site, paint, along, o.from, n0, n1, z0, z1);
  upright(site, paint, opposite(along), o.to, n0, n1, z0, z1);
  const Rect rect = plan::both_sides(o.along_x, o.wall, o.from, o.to, half);
  level(site, paint, rect, z0, true);
  level(site, paint, rect, z1, false);
}

// Frame, mullions and a transom, without panes: rays and light pass, bodies do not.
void build_sashes(BuildingSite& site, const Opening& o, mesh::MaterialId trim, double z) {
  constexpr double kBar = 0.05, kDeep = 0.035, kEach = 0.75;
  const double n0 = o.wall - kDeep, n1 = o.wall + kDeep, z0 = z + o.sill, z1 = z + o.head;
  const auto bar = [&](double u0, double u1, double a, double b, double depth) {
    wall_box(site, o.along_x, trim, {u0, u1, n0 + depth, n1 - depth, a, b});
  };
  bar(o.from - kEmbedded, o.from + kBar, z0 - kEmbedded, z1 + kEmbedded, 0);
  bar(o.to - kBar, o.to + kEmbedded, z0 - kEmbedded, z1 + kEmbedded, 0);
  bar(o.from + kBar, o.to - kBar, z0 - kEmbedded, z0 + kBar, 0);
  bar(o.from + kBar, o.to - kBar, z1 - kBar, z1 + kEmbedded, 0);
  const double width = o.to - o.from;
  const int panes = std::max(1, static_cast<int>(std::ceil(width / kEach)));
  for (int i = 1; i < panes; ++i) {
    const double u = o.from + width * i / panes;
    bar(u - 0.022, u + 0.022, z0 + kBar, z1 - kBar, 0.004);
  }
  if (o.head - o.sill > 1.35) {
    const double at = z + o.sill + 0.68 * (o.head - o.sill);
    bar(o.from + kBar, o.to - kBar, at - 0.02, at + 0.02, 0.008);
  }
}

// A parapet's handrail and posts, where a balcony or porch is open.
void build_parapet(BuildingSite& site, const Opening& o, const NamedMaterial& metal, double z) {
  const double at = z + o.sill;
  constexpr double kRail = 0.1, kRadius = 0.02;
  mesh::MeshBuilder& b = site.parts.builder;
  b.bar(metal.id, wall_point(o.along_x, o.from, o.wall, at + kRail),
        wall_point(o.along_x, o.to, o.wall, at + kRail), kRadius);
  const int posts = std::max(2, static_cast<int>((o.to - o.from) / 0.8));
  for (int i = 1; i < posts; ++i) {
    const double u = o.from + (o.to - o.from) * i / posts;
    b.bar(metal.id, wall_point(o.along_x, u, o.wall, at - 0.01),
          wall_point(o.along_x, u, o.wall, at + kRail), 0.012);
  }
}

void build_window(BuildingSite& site, const Opening& o) {
  const RoomStyle& style = site.style(o.room0);
  const PlanRoom& room = site.plan.rooms[o.room0];
  const bool open = plan::is_one_of(room.type, "py");
  const double z = site.floor_z(o.room0), half = plan::wall_thickness(site.plan, o) / 2;
  const char* name = open ? "railing" : "window";
  const std::uint32_t object =
      site.begin(name, open ? Mpcat40::kRailing : Mpcat40::kWindow, o.room0);
  build_reveals(site, o, open ? style.wall.id : style.trim.id, z);
  if (open) {
    build_parapet(site, o, style.metal, z);
  } else {
    build_sashes(site, o, style.trim.id, z);
    // The sill board, on the room's side.
    const auto [n0, n1] = room.floor.range(!o.along_x);
    const bool high = o.wall > (n0 + n1) / 2;
    const double a = high ? o.wall - half - 0.04 : o.wall + 0.035;
    const double b = high ? o.wall - 0.035 : o.wall + half + 0.04;
    solid_box(site, o.along_x, style.trim.id,
              {o.from + 0.001, o.to - 0.001, a, b, z + o.sill - 0.008, z + o.sill + 0.022});
  }
  const double z0 = z + o.sill, z1 = z + o.head;
  add_obstacle(site, o.along_x, {o.from, o.to, o.wall - half, o.wall + half, z0, z1});
  add_thing(site, object, name, open ? style.metal : style.trim, o.room0,
            wall_point(o.along_x, o.from, o.wall - half, z0),
            wall_point(o.along_x, o.to, o.wall + half, z1));
  const Vec3d c = wall_point(o.along_x, o.from, o.wall, z + o.sill);
  const Vec3d e = wall_point(o.along_x, o.to - o.from, 0, 0);
  site.portals.push_back({to_float(c), to_float(e), to_float({0, 0, o.head - o.sill})});
}

}  // namespace

void build_opening(BuildingSite& site, const Opening& o) {
  if (o.kind == OpeningKind::kWindow) return build_window(site, o);
  if (o.kind == OpeningKind::kEntrance) return build_entrance(site, o);
  build_doorway(site, o);
}

}  // namespace enfilade::homes::looks
