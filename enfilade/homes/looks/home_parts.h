/// \file  What the walls, the furniture and the lamps of a home are added to, room by room.
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
  Rect floor;  ///< inner faces of its walls, world
  double floor_z = 0, ceiling_z = 2.6;
  /// Pieces of its walls with doors, arches or windows: nothing stands in front of doors; below
  /// windows only what is lower than the sill.
  struct WallHole {
    Side wall = Side::kPlusX;
    double from = 0, to = 0;      ///< x or y along the wall
    double sill = 0, head = 2.1;  ///< above the floor; a sill of 0 is a door or an arch
  };
  std::vector<WallHole> holes;
  std::vector<Rect> no_way;      ///< flights and their holes: nobody walks across
  std::vector<Rect> keep_clear;  ///< where doors swing, stairs begin, people pass: nothing stands
};

/// What furnishing adds to.
struct HomeParts {
  mesh::MeshBuilder& builder;
  std::vector<Obstacle>& obstacles;  ///< one or more boxes for each thing that a body could touch
  std::vector<Thing>& things;
  std::vector<mesh::Lamp>& lamps;
};

}  // namespace enfilade::homes::looks
