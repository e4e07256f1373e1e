#include "enfilade/homes/looks/architecture.h"

#include <algorithm>
#include <utility>

#include "enfilade/homes/looks/site.h"
#include "enfilade/homes/plan/openings.h"

namespace enfilade::homes::looks {
Vec3d wall_point(bool along_x, double u, double n, double z) {
  return along_x ? Vec3d{u, n, z} : Vec3d{n, u, z};
}

void wall_box(Site& site, bool along_x, mesh::MaterialId material, const WallBox& b) {
  site.parts.builder.box(material, wall_point(along_x, b.u0, b.n0, b.z0),
                         wall_point(along_x, b.u1, b.n1, b.z1));
}

void add_obstacle(Site& site, bool along_x, const WallBox& b) {
  const double u = (b.u0 + b.u1) / 2, n = (b.n0 + b.n1) / 2;
  const double hu = (b.u1 - b.u0) / 2, hn = (b.n1 - b.n0) / 2;
  const Vec3d middle = wall_point(along_x, u, n, 0), half = wall_point(along_x, hu, hn, 0);
  site.parts.obstacles.push_back({middle.x, middle.y, half.x, half.y, 0, b.z0, b.z1});
}

void solid_box(Site& site, bool along_x, mesh::MaterialId material, const WallBox& box) {
  wall_box(site, along_x, material, box);
  add_obstacle(site, along_x, box);
}

void upright(Site& site, mesh::MaterialId material, Side facing, double n, double u0, double u1,
             double z0, double z1) {
  if (u1 - u0 < 1e-9 || z1 - z0 < 1e-9) return;
  const bool along_x = runs_along_x(facing);
  // Seen from the front, u grows to the right for +x and -y.
  const bool rising = facing == Side::kPlusX || facing == Side::kMinusY;
  const double a = rising ? u0 : u1, b = rising ? u1 : u0;
  site.parts.builder.quad(material, wall_point(along_x, a, n, z0), wall_point(along_x, b, n, z0),
                          wall_point(along_x, b, n, z1), wall_point(along_x, a, n, z1));
}

void level(Site& site, mesh::MaterialId material, const Rect& r, double z, bool up) {
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

void add_thing(Site& site, std::uint32_t object, const char* noun, const NamedMaterial& material,
               std::size_t room, Vec3d a, Vec3d b, double margin) {
  const Vec3d low{std::min(a.x, b.x) - margin, std::min(a.y, b.y) - margin, a.z};
  const Vec3d high{std::max(a.x, b.x) + margin, std::max(a.y, b.y) + margin, b.z};
  site.parts.things.push_back({object, noun, material.colour, material.material, room, low, high});
}

void build_architecture(const Plan& plan, const std::vector<RoomStyle>& styles, HomeParts parts,
                        std::vector<mesh::Portal>& portals) {
  Site site{plan, styles, parts, portals};
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
      if (o.kind == Opening::Kind::kWindow) continue;
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

}  // namespace enfilade::homes::looks
