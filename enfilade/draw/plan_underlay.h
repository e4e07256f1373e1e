/// \file  What a floor plan shows below the graph: walls, doors, windows, stairs, names of rooms.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "enfilade/geometry/vec.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/mesh/mesh.h"

namespace enfilade::draw {

struct UnderlayLine {
  enum class Kind : std::uint8_t {
    kThing,  ///< furniture
    kStairs,
    kWindow,
    kDoor,
    kWall,  ///< and whatever has no label
  };
  Kind kind = Kind::kWall;
  Vec3f from, to;  ///< world, metres
};

struct UnderlayText {
  Vec3f at;  ///< its middle; world
  std::string text;
};

struct UnderlayStorey {
  std::vector<UnderlayLine> lines;
  std::vector<UnderlayText> texts;
};

/// One of find_storeys(graph) each, lowest first.
struct PlanUnderlay {
  std::vector<UnderlayStorey> storeys;
};

/// Cuts a building 1.2 m above each storey's floor, above most furniture and through doors and
/// windows, as plans do, and 0.45 m above it, through furniture. Where the mesh has categories of
/// mpcat40, doors, windows and the treads of stairs are told from walls. Left out: what lies more
/// than 3 m outside the box around a storey's viewpoints. \pre mesh::check() finds no errors
PlanUnderlay plan_underlay(const mesh::Mesh& mesh, const graph::NavGraph& graph);

/// Adds a name to the storey whose floor is nearest. Nothing where there is no storey.
void add_text(PlanUnderlay& underlay, const graph::NavGraph& graph, Vec3f at,
              const std::string& text);

}  // namespace enfilade::draw
