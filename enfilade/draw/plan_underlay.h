/// \file  Background of a floor plan: walls, doors, windows, stairs and room names.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "enfilade/geometry/vec.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/mesh/mesh.h"

namespace enfilade::draw {

/// A line of a building's plan.
struct UnderlayLine {
  /// Kind of the line; each has a colour of its own.
  enum class Kind : std::uint8_t {
    kThing,  ///< furniture
    kStairs,
    kWindow,
    kDoor,
    kWall,  ///< and surfaces without label
  };
  Kind kind = Kind::kWall;
  Vec3f from, to;  ///< world, metres
};

/// A kind of lines as files name it.
struct UnderlayKind {
  const char* name;
  UnderlayLine::Kind kind;
};
/// All kinds, in the order of files.
inline constexpr std::array<UnderlayKind, 5> kUnderlayKinds{
    {{"walls", UnderlayLine::Kind::kWall},
     {"doors", UnderlayLine::Kind::kDoor},
     {"windows", UnderlayLine::Kind::kWindow},
     {"stairs", UnderlayLine::Kind::kStairs},
     {"furniture", UnderlayLine::Kind::kThing}}};

/// The lines of a kind as files have them, in metres. A line has four numbers: x and y of the
/// start, x and y of the end.
/// \param step metres to which they are rounded, > 0
std::vector<double> line_ends(const std::vector<UnderlayLine>& lines, UnderlayLine::Kind kind,
                              double step = 0.001);

/// A word on a building's plan, such as a room's name.
struct UnderlayText {
  Vec3f at;  ///< centre; world, metres
  std::string text;
};

/// Lines and words of one storey.
struct UnderlayStorey {
  std::vector<UnderlayLine> lines;
  std::vector<UnderlayText> texts;
};

/// One entry for each of find_storeys(graph), lowest first.
struct PlanUnderlay {
  std::vector<UnderlayStorey> storeys;
};

/// Cross-sections of a building 1.2 m above each storey's floor (doors and windows) and 0.45 m
/// above it (furniture). Doors, windows and stairs are distinguished if the mesh has categories of
/// mpcat40. Leaves out everything more than 3 m outside the box around a storey's viewpoints. \pre
/// mesh::check() finds no errors
PlanUnderlay plan_underlay(const mesh::Mesh& mesh, const graph::NavGraph& graph);

}  // namespace enfilade::draw
