/// \file  Appearance of rooms in synthetic homes, and the parts that walls and furniture are added
/// to.
#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/geometry/rect.h"
#include "enfilade/homes/home.h"
#include "enfilade/image/image.h"
#include "enfilade/mesh/mesh_builder.h"

namespace enfilade::homes::looks {

/// A material and the words for it.
struct NamedMaterial {
  mesh::MaterialId id;
  std::string colour;    ///< "dark brown"
  std::string material;  ///< "wooden"; may be empty
};

/// One room's choice. Rooms of one home share woods and metals. Walls, fabrics and accents differ,
/// so that no two rooms of a type have the same appearance.
struct RoomStyle {
  NamedMaterial wall, feature_wall;    ///< the latter for one wall of some rooms (may be the same)
  NamedMaterial floor, ceiling, trim;  ///< trim: skirting, frames, doors
  NamedMaterial wood, wood2, metal, steel;  ///< steel: of machines, alike in all homes
  NamedMaterial fabric, fabric2, accent;    ///< sofas and beds; cushions; rugs and curtains
  NamedMaterial stone;                      ///< worktops, bathrooms
  NamedMaterial white, glass, black;
  NamedMaterial rug;    ///< the accent's colour, stretched once over a face
  NamedMaterial linen;  ///< sheets, towels, lampshades that do not glow
  NamedMaterial leaf, leaf2, pot;
  NamedMaterial shade, glow;  ///< shine themselves: lampshades, bulbs
  NamedMaterial mirror, screen;
  std::vector<NamedMaterial> paints;  ///< plain colours: books, toys, boxes, clothes
  /// Paintings, each stretched once over a face, this room's first; a home's rooms share them.
  std::vector<NamedMaterial> pictures;
};

/// Draws styles for all rooms of a plan and adds their materials (textures made here: planks,
/// tiles, carpet, marble, brick, weave, wallpaper, plaster). One a room, by place in plan.rooms.
std::vector<RoomStyle> make_styles(const Plan& plan, mesh::MeshBuilder& builder,
                                   HomeSurfaces surfaces = HomeSurfaces::kTextured);

/// A made-up painting: abstract, a landscape or a portrait. 3 channels.
image::Image8 paint_picture(Rng& rng, std::uint32_t width, std::uint32_t height);

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
  std::vector<HomeThing>& things;
  std::vector<mesh::Lamp>& lamps;
};

}  // namespace enfilade::homes::looks
