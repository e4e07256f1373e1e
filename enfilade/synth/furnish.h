/// \file  Furniture and fittings of one room, placed as people place them.
#pragma once
#include <vector>

#include "enfilade/synth/home.h"
#include "enfilade/synth/mesh_builder.h"
#include "enfilade/synth/style.h"

namespace enfilade::synth {

/// A room to be furnished. Walls are named by direction: 0 +x (at floor.x1), 1 +y, 2 -x, 3 -y.
struct RoomSpace {
  std::size_t room = 0;  ///< place in plan.rooms
  char type = '-';
  Rect floor;  ///< inner faces of its walls, world
  double floor_z = 0, ceiling_z = 2.6;
  /// Pieces of its walls with doors, arches or windows: nothing stands in front of doors; below
  /// windows only what is lower than the sill.
  struct WallHole {
    unsigned wall = 0;
    double from = 0, to = 0;      ///< x or y along the wall
    double sill = 0, head = 2.1;  ///< above the floor; a sill of 0 is a door or an arch
  };
  std::vector<WallHole> holes;
  std::vector<Rect> no_way;      ///< flights and their holes: nobody walks across
  std::vector<Rect> keep_clear;  ///< where doors swing, stairs begin, people pass: nothing stands
};

/// What furnishing adds to.
struct HomeParts {
  MeshBuilder& builder;
  std::vector<Obstacle>& obstacles;  ///< one or more boxes for each thing that a body could touch
  std::vector<Thing>& things;
  std::vector<mesh::Lamp>& lamps;
};

/// Furnishes a room: what its type needs (bed against a wall, chairs around a table, sink below a
/// mirror, desks with chairs, ...), then what fits of what it may have, clutter on surfaces,
/// pictures and curtains on walls, a rug, lamps. At least 0.75 m stay free to walk from every door
/// to every other. Draws from `rng` only.
void furnish(const RoomSpace& space, const RoomStyle& style, Rng& rng, HomeParts parts);

/// All names of things that furnish() may place, with their mpcat40 category and how many shapes
/// each has: for tests and docs.
struct CatalogueEntry {
  std::string noun;
  std::uint16_t category = 0;
  unsigned shapes = 0;
};
std::vector<CatalogueEntry> catalogue();

}  // namespace enfilade::synth
