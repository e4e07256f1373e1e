/// \file  For tests: a home of bare walls and boxes, built from any plan, with a graph.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "enfilade/graph/nav_graph.h"
#include "enfilade/homes/home.h"
#include "enfilade/mesh/ray_tracer.h"

namespace enfilade::homes::instructions::testing {

/// A box that stands for a piece of furniture.
struct BoxThing {
  std::string noun, colour, material;
  std::size_t room = 0;
  Vec3d low, high;
};

/// Walls with holes for doors and arches, floors, flights as ramps of steps, and the boxes.
Home box_home(const Plan& plan, const std::vector<BoxThing>& things);

/// Two storeys. Below: a hallway along x (0); to its north, joined by an arch, a kitchen (1) and a
/// living room (2). To its south a bedroom (3) and an office (4), to its east stairs (5). Above:
/// the stairs (6), a landing (7) and a bathroom (8).
Plan small_plan();
Home small_home();
/// Viewpoints of small_home(), in rooms and doorways, at 1.5 m; edges where the way is free.
graph::NavGraph small_graph(const mesh::RayTracer& tracer);

/// Doors of its plan and a grid in its rooms as viewpoints.
graph::NavGraph grid_graph(const Plan& plan, const mesh::RayTracer& tracer,
                           const std::string& scan);

std::shared_ptr<mesh::RayTracer> tracer_of(const Home& home);

}  // namespace enfilade::homes::instructions::testing
