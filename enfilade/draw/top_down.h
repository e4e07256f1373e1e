/// \file  Top-down maps of a floor with trajectories, as SVG.
#pragma once
#include <span>
#include <string>
#include <vector>

#include "enfilade/draw/floor_plan.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/mesh/floor_polygons.h"

namespace enfilade::draw {

/// A line on the floor. A reference has its points, and a ring of the success distance at its end.
struct WalkedLine {
  PathRole role = PathRole::kAgent;
  std::vector<Vec3d> points;  ///< world, metres; at least one
  std::string label;          ///< for the legend; empty: named by its role
};

/// The points of a trajectory, each once while the body does not move, as in a turn.
std::vector<Vec3d> walked_points(std::span<const Vec3f> positions);

/// Texts and marks of a map.
struct TopDownOptions {
  std::string title = {};         ///< may be empty
  std::string note = {};          ///< a paragraph below it, such as the instruction; may be empty
  double success_distance = 3.0;  ///< metres; radius of the ring around the reference's end
};

/// Heights of storeys, lowest first: the most frequent heights of the floor, at least 1.8 m apart,
/// each with a twelfth of its area.
/// \pre floor has a polygon
std::vector<double> find_floor_levels(const mesh::FloorPolygons& floor);

/// A self-contained SVG document: one panel per storey, lowest first, all at one scale, north (+y)
/// up, with a scale bar and a legend. Floor and lines between storeys, as on stairs, are drawn with
/// the nearer storey. It has its own background, for light and dark pages. Texts are escaped.
/// \throws ArgumentError for a line without a point or with one that is not finite, or a
/// distance that is negative or not finite
/// \throws as mesh::FloorPolygons' users, for no polygon
std::string top_down_svg(const mesh::FloorPolygons& floor,
                         const std::vector<WalkedLine>& lines = {},
                         const TopDownOptions& options = {});

}  // namespace enfilade::draw
