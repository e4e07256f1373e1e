/// \file  A floor, walls and a ceiling around objects that were modelled without.
#pragma once
#include "enfilade/mesh/mesh.h"
#include "enfilade/mesh/ray_tracer.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::capture {

/// Size of the room around objects that were modelled without one.
struct PlainRoomOptions {
  double margin = 1.5;  ///< metres from the objects' box to the walls; >= 0
  double height = 3;    ///< least metres from floor to ceiling; > 0
};

/// Puts a mesh into a plain room: a floor of planks, four plastered walls, a ceiling, each an
/// object with its class. The floor is at the median of the standing objects' lowest points: those
/// within 0.3 m of the lowest of all. So one object modelled a little low does not leave the others
/// in the air.
/// \pre mesh has a triangle
/// \throws ArgumentError for options out of range
void add_plain_room(mesh::Mesh& mesh, const PlainRoomOptions& options = {});

/// Share of directions below the horizon, from the included viewpoints, in which rays meet
/// nothing, [0, 1]; 0 without viewpoints. From one half on, the mesh probably lacks a floor, or has
/// another axis up.
double share_of_nothing_below(const mesh::RayTracer& tracer, const scan::Connectivity& graph);

}  // namespace enfilade::capture
