/// \file  Floor plans as SVG: of a navigation graph, with paths and trajectories; of the
/// differences between two graphs of one building.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/draw/plan_underlay.h"
#include "enfilade/draw/planned_goal.h"
#include "enfilade/graph/compare.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::draw {

/// Whose path it is.
enum class PathRole {
  kReference,  ///< a wide band to the goal
  kAgent,      ///< a line, darker as time passes; a ring where it ends
};

/// A path to draw. Immediate repetitions of a viewpoint (turning in place) are drawn once. A
/// reference's last viewpoint is the goal, unless it is the only one.
struct PlannedPath {
  PathRole role = PathRole::kAgent;
  std::vector<ViewpointIndex> viewpoints;  ///< at least one; repeats are fine
  std::string label;                       ///< for the legend; empty: named by its role
};

/// Texts and marks of a floor plan.
struct FloorPlanOptions {
  std::string title;  ///< empty: the scan id
  std::string note;   ///< a paragraph below it, such as the instruction; may be empty
  std::vector<std::string> lines = {};  ///< paragraphs below the note: episode_lines()
  double pixels_per_metre = 0;          ///< > 0; or 0: fits about 1400 x 1000 pixels
  bool label_viewpoints = false;        ///< their index beside each
  bool show_excluded = true;            ///< as hollow grey dots
  double success_distance = 3.0;        ///< metres; radius of the circle around a goal
  /// Walls and room names, made for the same graph; null: the surroundings of edges are shaded
  /// instead. Must outlive the call.
  const PlanUnderlay* underlay = nullptr;
  /// Goals of episodes, if not the end of their path. There is no circle around the end of
  /// the reference path then, except where the goal is a turning point.
  std::optional<PlannedGoal> goal = {};
};

/// A floor of a building.
struct GraphStorey {
  double floor = 0;  ///< metres, world z: the median of its viewpoints' floors
  std::vector<ViewpointIndex> viewpoints;  ///< ascending
};

/// Storeys of a building, lowest first: groups of viewpoints with about the same floor height (z of
/// the viewpoint less `height`), at least 1.8 m apart. Each but the largest has at least three
/// viewpoints and 3 % of all within 0.25 m. Viewpoints on stairs and landings belong to the nearest
/// storey; each included viewpoint to exactly one. Empty for an empty graph.
std::vector<GraphStorey> find_storeys(const graph::NavGraph& graph);
/// Index of the storey whose floor is nearest to a height, world z. \pre !storeys.empty()
std::size_t nearest_storey(const std::vector<GraphStorey>& storeys, double floor);

/// A self-contained SVG document: one panel per storey, lowest first, all at one scale, north (+y)
/// up, with scale bar and legend. Edges between storeys are drawn on both, dashed, with a mark at
/// their other end. It has its own background, for light and dark pages; its colours suit
/// colour-blind readers. Texts are escaped.
/// \throws ArgumentError for an empty path, or a path or goal with a viewpoint that is not below
/// graph.size()
/// \throws ArgumentError for a scale or success distance that is negative or not finite, or an
/// underlay of another number of storeys
std::string floor_plan_svg(const graph::NavGraph& graph, const std::vector<PlannedPath>& paths = {},
                           const FloorPlanOptions& options = {});

/// Texts on the drawing of two graphs.
struct ComparisonPlanOptions {
  std::string title;              ///< empty: the scan id
  std::string note;               ///< a paragraph below the numbers; may be empty
  bool label_viewpoints = false;  ///< their index beside each
};

/// Draws the viewpoints of `found`, one panel a storey. Edges of both graphs are grey, extra ones
/// red and solid, missing ones blue and dashed. Precision, recall and F1 are below the title. \pre
/// comparison is compare(found, ...) \throws ArgumentError if it holds a viewpoint that is not
/// below found.size()
std::string graph_comparison_svg(const graph::NavGraph& found,
                                 const graph::GraphComparison& comparison,
                                 const ComparisonPlanOptions& options = {});

}  // namespace enfilade::draw
