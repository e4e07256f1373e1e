/// \file  A floor, walls and a ceiling around things that were modelled without.
#pragma once
#include "enfilade/mesh/mesh.h"

namespace enfilade::capture {

/// Size of the room around things that were modelled without one.
struct PlainRoomOptions {
  double margin = 1.5;  ///< metres from the things' box to the walls; >= 0
  double height = 3;    ///< least metres from floor to ceiling; > 0
};

/// Puts a mesh into a plain room of its own: a floor of planks, four plastered walls, a ceiling,
/// each an object with its class. The floor lies where most of what stands stands: at the median of
/// the lowest points of those objects that reach within 0.3 m of the lowest of all, so that a thing
/// modelled a little low does not lift the others off it. \pre mesh has a triangle
/// \throws ArgumentError for options out of range
void add_plain_room(mesh::Mesh& mesh, const PlainRoomOptions& options = {});

}  // namespace enfilade::capture
