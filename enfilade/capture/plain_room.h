/// \file  A floor, walls and a ceiling around objects that were modelled without.
#pragma once
#include "enfilade/mesh/mesh.h"
#include "enfilade/mesh/ray_tracer.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::capture {

/// Puts a mesh into a plain room: a floor of planks, four plastered walls, a ceiling, each an
/// object with its class. Walls are 1.5 m from the objects' box, the ceiling is 3 m above the floor
/// or more. The floor is at the median of the standing objects' lowest points: those within 0.3 m
/// of the lowest of all. So one object modelled a little low does not leave the others in the air.
/// \pre mesh has a triangle
void add_plain_room(mesh::Mesh& mesh);

/// Share of directions below the horizon, from the included viewpoints, in which rays meet
/// nothing, [0, 1]; 0 without viewpoints. From one half on, the mesh probably lacks a floor, or has
/// another axis up.
double share_of_nothing_below(const mesh::RayTracer& tracer, const scan::Connectivity& graph);

}  // namespace enfilade::capture
