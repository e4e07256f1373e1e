/// \file  A plan's walls, floors, ceilings, doors, windows and stairs as triangles; and the
/// building site, which the sources that build them share.
#pragma once
#include <cstddef>
#include <vector>

#include "enfilade/homes/looks/style.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::looks {

/// Builds the parts of a plan that are not furniture. Inside: walls with their openings, skirting,
/// floors, ceilings, door frames and leaves, window frames, stairs with railings. Outside: the
/// ground and a plain facade. Windows have no glass, so that light comes in, but count as
/// obstacles. Each wall, floor, ceiling, door, window and flight is an object of its own, with its
/// room. Adds obstacles and objects for doors, windows and stairs; adds the openings that let light
/// in to `portals`.
void build_architecture(const Plan& plan, const std::vector<RoomStyle>& styles, HomeParts parts,
                        std::vector<mesh::Portal>& portals);

/// The space for furniture in each room, in the plan's order. Flights and landings are kept clear.
std::vector<RoomSpace> room_spaces(const Plan& plan);

using mesh::Mpcat40;

/// Metres: width of a door's casing beside the hole. Skirting ends there.
inline constexpr double kCasing = 0.05;

/// A plan, and the parts of a home that are built from it.
struct BuildingSite {
  const Plan& plan;
  const std::vector<RoomStyle>& styles;
  HomeParts parts;
  std::vector<mesh::Portal>& portals;

  const RoomStyle& style(std::size_t room) const { return styles[room]; }
  double floor_z(std::size_t room) const { return plan.storeys[plan.rooms[room].storey].floor; }
  /// Begins an object of a room.
  std::uint32_t begin(const char* name, std::uint16_t category, std::size_t room,
                      const mesh::Placement& at = {}) {
    return parts.builder.begin_object(name, category, static_cast<std::int32_t>(room), at);
  }
};

/// A range along each axis of a wall: u along it, n across it, z up.
struct WallBox {
  double u0 = 0, u1 = 0, n0 = 0, n1 = 0, z0 = 0, z1 = 0;
};
Vec3d wall_point(bool along_x, double u, double n, double z);
/// A box of the current object (which stands unturned).
void wall_box(BuildingSite& site, bool along_x, mesh::MaterialId material, const WallBox& box);
/// The same, and an obstacle.
void solid_box(BuildingSite& site, bool along_x, mesh::MaterialId material, const WallBox& box);
void add_obstacle(BuildingSite& site, bool along_x, const WallBox& box);
/// An upright face towards `facing`, at `n` of that axis.
void upright(BuildingSite& site, mesh::MaterialId material, Side facing, double n, double u0,
             double u1, double z0, double z1);
/// A level face, facing up or down.
void level(BuildingSite& site, mesh::MaterialId material, const Rect& rect, double z, bool up);
/// The rest of a rectangle around a hole in it (either may be empty).
std::vector<Rect> around(const Rect& rect, const Rect* hole);
/// An object between two opposite corners, `margin` metres wider on all sides.
void add_thing(BuildingSite& site, std::uint32_t object, const char* noun,
               const NamedMaterial& material, std::size_t room, Vec3d a, Vec3d b,
               double margin = 0);

/// Walls, skirting, floors with thresholds, ceilings of one room.
void build_room(BuildingSite& site, std::size_t room);
/// A door, arch, window or front door.
void build_opening(BuildingSite& site, const Opening& opening);
/// Steps, railings, the hole in the floor above with its guard.
void build_stairs(BuildingSite& site, const Stairs& stairs);
/// Facade, roof, ground and what stands around.
void build_outside(BuildingSite& site);

}  // namespace enfilade::homes::looks
