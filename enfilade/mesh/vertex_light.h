/// \file  A mesh with its light in the colours of its corners, for viewers that compute no light.
#pragma once
#include <cstddef>

#include "enfilade/mesh/lighting.h"
#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh {

/// How finely light is kept.
struct VertexLightOptions {
  double least_edge = 0.12;  ///< metres: shorter edges are not cut; > 0
  double most_edge = 1.5;    ///< metres: longer ones in rooms are cut; >= least_edge.
  /// An edge is cut if the light at its middle differs from its ends' mean by more than this share
  /// of a screen's range. (0, 1]
  float tolerance = 0.04F;
  std::size_t most_triangles = 250'000;  ///< at this number no edge is cut any more
  int threads = 0;                       ///< 0: all cores; does not change the result
};

/// A mesh without light sources that looks lit. Its `colours` are the light on the front of each
/// surface times LitMesh's exposure. So texture times colour is the linear radiance that
/// image::shoulder() takes.
///
/// Triangles are cut at middles of edges until light can be interpolated between corners. An edge
/// that two triangles share is cut in both or in none. Surfaces that shine have a colour of their
/// own and no texture. Mirrors are grey, as their image depends on the position of the eye. There
/// are two objects: 0 "building", and 1 "surroundings", the surfaces that belong to no room. A mesh
/// without rooms is all building. In the surroundings, edges below four times `most_edge` are not
/// cut. There are no normals. Deterministic.
/// \throws ArgumentError for options out of range
Mesh with_vertex_light(const LitMesh& light, const VertexLightOptions& options = {});

}  // namespace enfilade::mesh
