/// \file  The cells of a walkable floor, and their exact heights, which Recast rounds to its
/// levels.
#pragma once
#include <cstdint>
#include <vector>

#include "enfilade/mesh/mesh.h"
#include "enfilade/mesh/walkable.h"

namespace enfilade::mesh::detail {

/// How a building is cut into columns and levels. Column (i, j) has its middle at
/// box.low.x + (i + 0.5) cell, ...
struct Lattice {
  Box box;
  double cell = 0, level = 0;  ///< metres
  int width = 0, depth = 0;    ///< columns along x, y
};

/// Floor as lists: cells by column, links by cell.
struct Cells {
  std::vector<FloorCell> cells;
  std::vector<std::uint32_t> first_in_column;  ///< columns + 1
  std::vector<std::uint32_t> first_link;       ///< cells + 1
  std::vector<std::uint32_t> links;
};

/// Moves each cell to the highest surface at its centre that is near its height. Recast's cells
/// have the height of the highest surface anywhere in them, such as the next stair. If there is no
/// surface (a crack between triangles), the cell is lowered by half a level, the mean error.
/// \param step how far a cell may lie above the surface at its middle
void set_exact_heights(const Mesh& mesh, const Lattice& lattice, double step, Cells& floor);

}  // namespace enfilade::mesh::detail
