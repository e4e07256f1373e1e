/// \file  Where a body can stand and walk in a mesh (Recast's heightfields).
#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "enfilade/mesh/mesh.h"

namespace enfilade::mesh {

/// A walking body: an upright cylinder.
struct Body {
  double radius = 0.25;  ///< metres
  double height = 1.6;   ///< head-room that it needs
  double step = 0.3;     ///< highest step that it climbs; stairs are steps
  double slope = 40;     ///< steepest floor, degrees
};

struct WalkableOptions {
  Body body;
  double cell = 0.07;       ///< metres between places looked at
  double least_area = 1.0;  ///< m2; smaller islands of floor (table tops) are dropped
};

/// A place at which the body can stand.
struct FloorCell {
  Vec3f position;          ///< middle of the cell, on the floor
  float clearance = 0;     ///< metres to the nearest place where it cannot stand
  std::uint32_t area = 0;  ///< which connected part, 0 the largest
  bool covered = false;    ///< there is something above it: a ceiling, a roof
};

/// The floor that a body can reach within each connected part. Parts are ranked by size; if one
/// has 8 m2 with something above it, by what of them is covered, so that a house comes before the
/// meadow around it. Roofs are left out: parts under the sky, most of which lies above other
/// parts. Immutable; any thread.
class WalkableFloor {
 public:
  /// \throws ArgumentError for options out of range; InvalidInput (`no-floor`) if the body can
  /// stand nowhere, saying why: no surface flat enough, no head-room, all islands too small
  WalkableFloor(const Mesh& mesh, const WalkableOptions& options = {});
  ~WalkableFloor();
  WalkableFloor(WalkableFloor&&) noexcept;
  WalkableFloor& operator=(WalkableFloor&&) noexcept;

  const WalkableOptions& options() const noexcept;
  std::span<const FloorCell> cells() const noexcept;
  /// Cells that one step leads to from a cell: up to 8.
  std::span<const std::uint32_t> neighbours(std::size_t cell) const noexcept;
  std::size_t areas() const noexcept;  ///< connected parts
  double area_m2() const noexcept;     ///< of all cells
  /// The cell below or at a point, at most `drop` metres down and half a cell aside.
  std::optional<std::size_t> below(Vec3f point, double drop = 2.5) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace enfilade::mesh
