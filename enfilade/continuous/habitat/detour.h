/// \file  Between Habitat's navigation meshes and Detour.
#pragma once
#include <DetourNavMesh.h>

#include <array>
#include <memory>

#include "enfilade/continuous/habitat/nav_mesh.h"

namespace enfilade::continuous::habitat {

/// The flag of polygons that bodies may be on.
inline constexpr unsigned short kWalkable = 1;

inline std::array<float, 3> array_of(Vec3f p) { return {p.x, p.y, p.z}; }
inline Vec3f point_of(const float* p) { return {p[0], p[1], p[2]}; }

/// Detour's mesh, links made. Polygons without area are not walkable in it.
/// \throws InvalidInput `damaged` for tiles that do not fit together. \param name  for messages
std::unique_ptr<dtNavMesh> open_in_detour(const NavMesh& mesh, const std::string& name);

/// The tiles of a mesh as Detour has them in memory, and the numbers of its whole.
void take_from_detour(const dtNavMesh& mesh, NavMesh& out);

}  // namespace enfilade::continuous::habitat
