/// \file  Content and layout of a floor plan; pieces of SVG for it.
#pragma once
#include <fmt/format.h>
#include <cstddef>
#include <iterator>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "enfilade/draw/floor_plan.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::draw::plan {

/// A point on the sheet, or a vector: pixels, y down.
struct Point {
  double x = 0, y = 0;

  friend constexpr Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y}; }
  friend constexpr Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y}; }
  friend constexpr Point operator*(double k, Point a) { return {k * a.x, k * a.y}; }
};

/// "12.3,45": coordinates to a tenth of a pixel.
std::string pair(Point p);
std::string number(double value);

/// Estimated width of a text in sans-serif at `size` pixels, on the large side, as the font is the
/// viewer's.
double text_width(std::string_view text, double size);

/// Lines of at most `width` pixels (as text_width() has it), broken at blanks; longer words stay
/// whole. Empty text: no line.
std::vector<std::string> wrap(std::string_view text, double size, double width);

template <class... Args>
void append(std::string& out, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(out), format, std::forward<Args>(args)...);
}

struct PlanEdge {
  ViewpointIndex a, b;
};

/// A graph sorted into storeys.
struct StoreyPlan {
  static constexpr std::size_t kNowhere = static_cast<std::size_t>(-1);

  const graph::NavGraph& graph;
  std::vector<GraphStorey> storeys;    ///< their viewpoints: included ones
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
StoreyPlan make_plan(const graph::NavGraph& graph, bool show_excluded);

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
struct PanelLayout {
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
Caption caption(const StoreyPlan& plan, std::size_t storey);

/// Something round that a panel must have room for.
struct Disc {
  ViewpointIndex centre;
  double radius = 0;  ///< metres
};

/// `underlay`: room for it too; may be null. `pixels_per_metre`: 0 for the largest scale at which
/// the sheet stays small enough to read.
PanelLayout arrange(const StoreyPlan& plan, const std::vector<Disc>& discs,
                    const PlanUnderlay* underlay, double pixels_per_metre);

}  // namespace enfilade::draw::plan
