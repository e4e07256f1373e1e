/// \file  What the parts of architecture.cpp have in common.
#pragma once
#include <cstddef>
#include <vector>

#include "enfilade/homes/looks/architecture.h"
#include "enfilade/mesh/mpcat40.h"

namespace enfilade::homes::looks {

inline constexpr double kCasing =
    0.05;  ///< metres: width of a door's casing beside the hole; skirting ends there

struct Site {
  const Plan& plan;
  const std::vector<RoomStyle>& styles;
  HomeParts parts;
  std::vector<mesh::Portal>& portals;

  const RoomStyle& style(std::size_t room) const { return styles[room]; }
  double floor_z(std::size_t room) const { return plan.storeys[plan.rooms[room].storey].floor; }
};

/// A range along each axis of a wall: u along it, n across it, z up.
struct WallBox {
  double u0 = 0, u1 = 0, n0 = 0, n1 = 0, z0 = 0, z1 = 0;
};
Vec3d wall_point(bool along_x, double u, double n, double z);
/// A box of the current object (which stands unturned).
void wall_box(Site& site, bool along_x, mesh::MaterialId material, const WallBox& box);
/// The same, and an obstacle.
void solid_box(Site& site, bool along_x, mesh::MaterialId material, const WallBox& box);
void add_obstacle(Site& site, bool along_x, const WallBox& box);
/// An upright face that looks towards `facing`, at `n` of that axis.
void upright(Site& site, mesh::MaterialId material, Side facing, double n, double u0, double u1,
             double z0, double z1);
/// A level face that looks up or down.
void level(Site& site, mesh::MaterialId material, const Rect& rect, double z, bool up);
/// What is left of a rectangle around a hole in it (either may be empty).
std::vector<Rect> around(const Rect& rect, const Rect* hole);
void add_thing(Site& site, std::uint32_t object, const char* noun, const NamedMaterial& material,
               std::size_t room, Vec3d low, Vec3d high);

/// Walls, skirting, floors with thresholds, ceilings of one room.
void build_room(Site& site, std::size_t room);
/// A door, arch, window or front door.
void build_opening(Site& site, const Opening& opening);
/// Steps, railings, the hole in the floor above with its guard.
void build_stairs(Site& site, const Stairs& stairs);
/// Facade, roof, ground and what stands around.
void build_outside(Site& site);

}  // namespace enfilade::homes::looks
