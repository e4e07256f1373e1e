/// \file  Exact heights of floor cells, which Recast rounds to its levels.
#pragma once
#include <span>

#include "enfilade/mesh/mesh.h"
#include "enfilade/mesh/walkable.h"

namespace enfilade::mesh::detail {

/// Columns of floor cells: column (i, j) has its middle at west + (i + 0.5) cell, ...
struct Columns {
  double west = 0, south = 0, cell = 0;
  int width = 0, depth = 0;
  std::span<const std::uint32_t> first;  ///< width * depth + 1 places in the cells
  double step = 0;                       ///< how far a cell may lie above what is at its middle
  double level = 0;                      ///< how far below
};

/// Moves each cell to the highest surface at its centre that is near its height. Recast's cells
/// have the height of the highest surface anywhere in them, such as the next stair. If there is no
/// surface (a crack between triangles), the cell is lowered by half a level, the mean error.
void set_exact_heights(const Mesh& mesh, const Columns& columns, std::span<FloorCell> cells);

}  // namespace enfilade::mesh::detail
