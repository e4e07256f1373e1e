/// \file  The walkable floor of a mesh as convex polygons (Recast): a navigation mesh.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/mesh/ray_tracer.h"
#include "enfilade/mesh/walkable.h"

namespace enfilade::mesh {

/// Body size, and how closely the polygons follow the floor's rim. If the box is too large for
/// cells of that size (520 m2 at 1.25 cm), cells and rim_error grow together until it is not.
/// FloorPolygons::cell has the result.
struct PolygonOptions {
  WalkableOptions floor{.body = {.radius = 0.1, .height = 1.5, .step = 0.2, .slope = 45},
                        .cell = 0.0125,
                        .least_area = 1.0};
  double rim_error = 0.01;     ///< metres that an edge of the rim may deviate; 0 .. 1
  double height_every = 0.2;   ///< metres between samples of the height inside polygons; 0.05 .. 10
  double height_error = 0.02;  ///< metres that a height may be off between them; 0.005 .. 1
};

/// A corner: places on the lattice, `low + (cell x, cell y, level z)` in the world.
using PolygonCorner = std::array<std::uint16_t, 3>;

/// A convex polygon, seen from above, with what lies beyond its sides.
struct FloorPolygon {
  static constexpr std::size_t kMostCorners = 6;
  static constexpr std::uint16_t kNone = 0xffff;
  /// Indices in FloorPolygons::corners, of one direction of turning in all polygons; kNone after
  /// the last.
  std::array<std::uint16_t, kMostCorners> corners{};
  /// The polygon beyond the side from corner k to the next; kNone: the rim.
  std::array<std::uint16_t, kMostCorners> beyond{};
  std::uint32_t area = 0;  ///< index of its connected part, as in FloorCell
  friend bool operator==(const FloorPolygon&, const FloorPolygon&) = default;

  /// Corners of this polygon: 3 .. kMostCorners.
  std::size_t size() const noexcept {
    std::size_t n = 0;
    while (n < kMostCorners && corners[n] != kNone) ++n;
    return n;
  }
};

/// The heights inside one polygon: triangles over its own corners, in order, and points of its own.
struct PolygonHeights {
  std::uint32_t first_point = 0, points = 0;        ///< in FloorPolygons::points
  std::uint32_t first_triangle = 0, triangles = 0;  ///< in FloorPolygons::triangles
  friend bool operator==(const PolygonHeights&, const PolygonHeights&) = default;
};

/// The walkable floor, on which the centre of a body may be. Areas are WalkableFloor's. A plain
/// value.
struct FloorPolygons {
  Body body;
  double cell = 0, level = 0;  ///< metres between places of the lattice
  Vec3f low, high;             ///< box around everything, world
  std::vector<PolygonCorner> corners;
  std::vector<FloorPolygon> polygons;
  std::vector<PolygonHeights> heights;  ///< per polygon
  std::vector<Vec3f> points;            ///< world, metres: corners of a polygon first
  /// Points of each triangle, counted from the polygon's first. Then a byte of Recast's flags:
  /// which sides are sides of the polygon.
  std::vector<std::array<std::uint8_t, 4>> triangles;
  friend bool operator==(const FloorPolygons& a, const FloorPolygons& b) {
    return a.cell == b.cell && a.level == b.level && a.low == b.low && a.high == b.high &&
           a.corners == b.corners && a.polygons == b.polygons && a.heights == b.heights &&
           a.points == b.points && a.triangles == b.triangles;
  }
};

/// Polygons of the floor of a mesh. Heights are those of the surfaces below the points, not
/// Recast's levels. Deterministic.
/// \throws ArgumentError for options out of range, or a floor of more than 65,534 corners or
/// polygons (take larger cells or a larger rim_error); InvalidInput (`no-floor`) as WalkableFloor
FloorPolygons make_floor_polygons(const RayTracer& tracer, const PolygonOptions& options = {});

}  // namespace enfilade::mesh
