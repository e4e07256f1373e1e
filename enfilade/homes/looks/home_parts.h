/// \file  A room to be furnished, and the parts of a home that walls and furniture are added to.
#pragma once
#include <cstddef>
#include <vector>

#include "enfilade/geometry/rect.h"
#include "enfilade/homes/home.h"
#include "enfilade/mesh/mesh_builder.h"

namespace enfilade::homes::looks {

/// A room to be furnished. Walls are named by the floor's side.
struct RoomSpace {
  std::size_t room = 0;  ///< place in plan.rooms
  char type = '-';
  Rect floor;                           ///< inner faces of its walls, world
  double floor_z = 0, ceiling_z = 2.6;  ///< world, metres
  /// A piece of a wall with a door, an arch or a window. Doors and arches have no furniture in
  /// front of them, windows only furniture lower than the sill.
  struct WallHole {
    Side wall = Side::kPlusX;
    double from = 0, to = 0;      ///< x or y along the wall; world, metres
    double sill = 0, head = 2.1;  ///< metres above the floor; a sill of 0 is a door or an arch
    bool is_door() const { return sill == 0; }
    double middle() const { return (from + to) / 2; }
  };
  std::vector<WallHole> holes;
  std::vector<Rect> no_way;      ///< flights and their holes: not walkable
  std::vector<Rect> keep_clear;  ///< where doors swing, stairs begin or people pass
};

/// The parts of a home that furniture is added to.
struct HomeParts {
  mesh::MeshBuilder& builder;
  std::vector<Obstacle>& obstacles;  ///< one or more boxes per object that a body could touch
  std::vector<Thing>& things;
  std::vector<mesh::Lamp>& lamps;
};

}  // namespace enfilade::homes::looks
