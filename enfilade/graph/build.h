/// \file  Navigation graphs out of meshes: the paper's section 3.2 for any building.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "enfilade/core/progress.h"
#include "enfilade/mesh/ray_tracer.h"
#include "enfilade/mesh/walkable.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::graph {

/// How viewpoints are spread over a walkable floor.
struct ViewpointOptions {
  double separation = 2.25;      ///< metres, mean length of edges in furnished homes; 0.2 .. 100
  double eye_height = 1.5;       ///< metres above the floor; lower where the ceiling is
  double least_clearance = 0.3;  ///< metres from obstacles, where there is room
  std::uint64_t seed = 1;
};

/// A viewpoint's position.
struct PlacedViewpoint {
  Vec3d eye;          ///< metres, world
  double height = 0;  ///< above the floor
};

/// Viewpoints spread over all of the floor's largest connected part (and the others that have room
/// for two). Each walkable cell is near one. They stand at commanding positions: much of the
/// surroundings in view, clear of walls, doorways and stairs covered. Deterministic.
std::vector<PlacedViewpoint> place_viewpoints(const mesh::RayTracer& tracer,
                                              const mesh::WalkableFloor& floor,
                                              const ViewpointOptions& options = {});

/// Which viewpoints are joined: those between which a body passes.
struct EdgeOptions {
  double longest = 5;  ///< metres, straight line
  double width = 0.4;  ///< of the body that moves along an edge, metres
  double lowest =
      0.35;  ///< of its lower end above the floor (sills, rugs and treads don't stop it)
  double highest = 1.55;                 ///< of its upper end
  std::uint32_t columns = 9, rows = 31;  ///< rays across the body
  bool need_floor = true;                ///< there must be walkable floor below all of it
};

/// The connectivity of viewpoints; symmetric. `unobstructed`: a bundle of rays as wide and as tall
/// as the body gets through the mesh, above walkable floor, at most `longest` long. `visible`: a
/// single ray does, at any distance. Poses look along +y (panoramas' face 3), ids are 32 hex digits
/// made from scan and position. Separate parts are kept, `included`; check_graph() reports them.
/// O(n^2) rays at worst, in parallel; `threads` 0: all cores.
scan::Connectivity connect_viewpoints(const mesh::RayTracer& tracer,
                                      const mesh::WalkableFloor& floor,
                                      const std::vector<PlacedViewpoint>& viewpoints,
                                      const std::string& scan, const EdgeOptions& options = {},
                                      int threads = 0, const Progress& progress = {});

}  // namespace enfilade::graph
