/// \file  Content and layout of a floor plan.
#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "enfilade/draw/floor_plan.h"
#include "enfilade/draw/plan/svg.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::draw::plan {

struct PlanEdge {
  ViewpointIndex a, b;
};

/// A graph sorted into storeys.
struct Plan {
  static constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);

  const graph::NavGraph& graph;
  std::vector<Storey> storeys;         ///< their viewpoints: included ones
  std::vector<std::size_t> storey_of;  ///< by viewpoint; kNowhere: not drawn
  std::vector<PlanEdge> edges;         ///< each pair once, for both directions

  /// Whether a line from a to b is drawn on this storey.
  bool touches(std::size_t storey, ViewpointIndex a, ViewpointIndex b) const {
    return storey_of[a.at()] == storey || storey_of[b.at()] == storey;
  }
  bool between_storeys(ViewpointIndex a, ViewpointIndex b) const {
    return storey_of[a.at()] != storey_of[b.at()];
  }
};
Plan make_plan(const graph::NavGraph& graph, bool show_excluded);

/// The part of the sheet that one storey is drawn in.
struct Panel {
  std::size_t storey = 0;
  Point corner;      ///< upper left
  Point size;        ///< pixels, caption included
  double west = 0;   ///< world x at corner.x
  double north = 0;  ///< world y at the upper end of the drawing
  double scale = 1;  ///< pixels a metre

  Point at(Vec3f world) const;  ///< straight down on the plan
};

/// Panels in rows, lowest storey first; the first one at (0, 0).
struct Layout {
  std::vector<Panel> panels;
  double scale = 1;  ///< pixels a metre
  Point size;        ///< of all panels together
};

inline constexpr double kCaption = 26;       ///< height of a panel's caption, pixels
inline constexpr double kFloorRadius = 0.9;  ///< metres around viewpoints that are shaded

/// "Storey 1" and its facts.
struct Caption {
  std::string name, facts;
};
Caption caption(const Plan& plan, std::size_t storey);

/// Something round that a panel must have room for.
struct Disc {
  ViewpointIndex centre;
  double radius = 0;  ///< metres
};

/// `underlay`: room for it too; may be null. `pixels_per_metre`: 0 for the largest scale at which
/// the sheet stays small enough to read.
Layout arrange(const Plan& plan, const std::vector<Disc>& discs, const PlanUnderlay* underlay,
               double pixels_per_metre);

}  // namespace enfilade::draw::plan
