/// \file  The walkable floor of a mesh (Recast's heightfields).
#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh {

/// A walking body: an upright cylinder.
struct Body {
  double radius = 0.25;  ///< metres
  double height = 1.6;   ///< metres of head-room
  double step = 0.3;     ///< highest step, metres; stairs are steps
  double slope = 40;     ///< steepest floor, degrees
};

/// Body size and grid resolution.
struct WalkableOptions {
  Body body = {};
  double cell = 0.07;  ///< grid spacing, metres
  /// `cell` grows on large meshes (over 128 m by 128 m at 0.07 m) until 3.3 million columns are
  /// left. Meshes that are too large for `cell` as given are refused all the same.
  bool growing_cell = false;
  double least_area = 1.0;  ///< m2; smaller islands of floor (table tops) are dropped
  /// Anything outside is ignored: a landscape around a building. No value: everything counts.
  std::optional<Box> within = {};
};

/// A grid cell in which the body can stand.
struct FloorCell {
  Vec3f position;          ///< centre of the cell, on the floor
  float clearance = 0;     ///< metres to the nearest cell that is not walkable
  std::uint32_t area = 0;  ///< index of its connected part; 0 is ranked first
  bool covered = false;    ///< under a ceiling or roof
};

/// How a building is cut into columns and levels. Column (i, j) has its middle at
/// box.low.x + (i + 0.5) cell, ...
struct FloorLattice {
  Box box;
  double cell = 0, level = 0;  ///< metres
  int width = 0, depth = 0;    ///< columns along x, y
};

/// Floor as lists: cells by column, links by cell.
struct FloorCells {
  std::vector<FloorCell> cells;
  std::vector<std::uint32_t> first_in_column;  ///< columns + 1
  std::vector<std::uint32_t> first_link;       ///< cells + 1
  std::vector<std::uint32_t> links;
};

/// The walkable floor, in connected parts, ranked by area. A part with at least 8 m2 of covered
/// floor is ranked by that, so that a home comes before the meadow around it. Roofs are left out:
/// uncovered parts that lie mostly above other parts. Immutable; any thread.
class WalkableFloor {
 public:
  /// \throws ArgumentError for options out of range; InvalidInput (`no-floor`) if there is
  /// none, with the reason: no surface flat enough, no head-room, all islands too small
  WalkableFloor(const Mesh& mesh, const WalkableOptions& options = {});

  /// As given, except a `cell` that has grown.
  const WalkableOptions& options() const noexcept { return options_; }
  std::span<const FloorCell> cells() const noexcept { return floor_.cells; }
  /// Indices of the cells that can be reached from a cell by one step: up to 8.
  std::span<const std::uint32_t> neighbours(std::size_t cell) const noexcept;
  std::size_t areas() const noexcept { return areas_; }  ///< connected parts
  double area_m2() const noexcept;                       ///< of all cells
  /// Index of the cell at or below a point, at most `drop` metres lower and half a cell aside.
  std::optional<std::size_t> below(Vec3f point, double drop = 2.5) const;

 private:
  WalkableOptions options_;
  FloorLattice lattice_;
  FloorCells floor_;
  std::size_t areas_ = 0;
};

}  // namespace enfilade::mesh
