/// \file  A mesh with its light in the colours of its corners, for viewers that compute no light.
#pragma once
#include <cstddef>

#include "enfilade/mesh/lighting.h"
#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh {

/// How finely light is kept.
struct VertexLightOptions {
  double least_edge = 0.12;  ///< metres: shorter edges are not cut; > 0
  double most_edge = 1.5;  ///< metres: longer ones in rooms are, whatever the light; >= least_edge
  /// An edge is cut where the light at its middle differs from the mean of its ends by more than
  /// this share of what a screen can show. (0, 1]
  float tolerance = 0.04F;
  std::size_t most_triangles = 250'000;  ///< no edge is cut any more when there are so many
  int threads = 0;                       ///< 0: all cores; does not change the result
};

/// A mesh without light sources that looks lit: its `colours` are the light on the front of each
/// surface times LitMesh's exposure, so that texture times colour is the linear radiance which
/// image::shoulder() takes. Triangles are cut at middles of edges until light can be interpolated
/// between corners; an edge that two triangles share is cut in both or in none. Surfaces that shine
/// have a colour of their own and no texture; mirrors are grey, as what they show depends on where
/// one stands. There are two objects: 0 "building", and 1 "surroundings", what belongs to no room; a
/// mesh without rooms is all building. Of the surroundings edges below four times `most_edge` are
/// not cut. There are no normals. Deterministic. \throws ArgumentError for options out of range
Mesh with_vertex_light(const LitMesh& light, const VertexLightOptions& options = {});

}  // namespace enfilade::mesh
