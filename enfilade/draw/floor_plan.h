/// \file  Floor plans of a navigation graph, with trajectories over them, as SVG.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::draw {

/// A path to draw over the plan.
struct PlannedPath {
  enum class Role { kReference, kAgent };
  Role role = Role::kAgent;
  std::vector<ViewpointIndex> viewpoints;  ///< at least one; repeats are fine
  std::string label;                       ///< for the legend; may be empty
};

struct FloorPlanOptions {
  std::string title;             ///< empty: the scan id
  double pixels_per_metre = 32;
  bool label_viewpoints = false; ///< their index beside each
  bool show_excluded = true;     ///< as hollow grey dots
};

/// Storeys of a building, lowest first: groups of viewpoints whose floors are at about one height
/// (viewpoint height less `height`). Viewpoints on stairs go to the nearest storey. Each included
/// viewpoint is in exactly one. Empty graph: none.
struct Storey {
  double floor = 0;  ///< metres, world z
  std::vector<ViewpointIndex> viewpoints;
};
std::vector<Storey> find_storeys(const graph::NavGraph& graph);

/// A self-contained SVG document: one panel a storey, all at one scale, north (+y) up, with scale
/// bar and legend. Edges between storeys are drawn on both, dashed. Readable in light and dark
/// surroundings (it has a background of its own). Ids and labels are escaped.
/// \throws ArgumentError if a path holds a viewpoint that is not below graph.size()
std::string floor_plan_svg(const graph::NavGraph& graph, const std::vector<PlannedPath>& paths = {},
                           const FloorPlanOptions& options = {});

}  // namespace enfilade::draw
