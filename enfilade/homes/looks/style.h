/// \file  Appearance of rooms in synthetic homes: materials with names that people would use.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "enfilade/core/rng.h"
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
                                   Surfaces surfaces = Surfaces::kTextured);

/// A made-up painting: abstract, a landscape or a portrait. 3 channels.
image::Image8 paint_picture(Rng& rng, std::uint32_t width, std::uint32_t height);

}  // namespace enfilade::homes::looks
