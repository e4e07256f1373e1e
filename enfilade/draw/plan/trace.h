/// \file  Paths on a floor plan, side by side where they use an edge more than once. Marks, used on
/// the plan and in its legend.
#pragma once
#include <string>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/draw/plan/plan.h"

namespace enfilade::draw::plan {

struct Colour {
  int red = 0, green = 0, blue = 0;
};
std::string hex(Colour colour);
/// `share` of b, the rest of a.
Colour mix(Colour a, Colour b, double share);

/// From one viewpoint to another, `side` pixels to the right of the straight line.
struct Step {
  ViewpointIndex from, to;
  double side = 0;
};

/// The steps of each path, without those that stay in place. A step over an edge that all paths use
/// once runs along its centre line. Others keep to the right, each further step in a direction
/// farther out, `spacing` pixels apart, or less if there are many.
std::vector<std::vector<Step>> lanes(const std::vector<std::vector<ViewpointIndex>>& paths,
                                     double spacing);

/// The steps that touch the panel's storey: a wide translucent band.
std::string draw_band(const StoreyPlan& plan, const Panel& panel, const std::vector<Step>& steps,
                      Colour colour);
/// The same as a line with an arrow on each step, from light to dark as time passes.
std::string draw_line(const StoreyPlan& plan, const Panel& panel, const std::vector<Step>& steps,
                      Colour colour);

inline constexpr double kBandWidth = 11;  ///< pixels
inline constexpr double kLineWidth = 3;

// Okabe and Ito's palette, safe for colour-blind readers.
inline constexpr Colour kBlue{0, 114, 178};
inline constexpr Colour kSky{86, 180, 233};
inline constexpr Colour kVermilion{213, 94, 0};
inline constexpr Colour kPurple{170, 70, 130};
inline constexpr Colour kGreen{0, 158, 115};
inline constexpr Colour kYellow{240, 228, 66};

inline constexpr const char* kInk = "#2b2f36";       ///< texts
inline constexpr const char* kFaintInk = "#6b7280";  ///< captions
inline constexpr const char* kEdge = "#a7acb5";
inline constexpr const char* kFloor = "#f3efe6";
inline constexpr const char* kFloorRim = "#d8d0be";

/// \param attributes how it is drawn: fill, stroke
std::string circle(Point p, double radius, std::string_view attributes);
std::string dot(Point p);
std::string isolated_mark(Point p);
std::string excluded_mark(Point p);
/// End of an edge that continues on another storey; `up`: a higher one.
std::string stairs_mark(Point p, bool up);
std::string start_mark(Point p);
std::string goal_mark(Point p);
/// Squares: viewpoints that see a goal's object. A diamond: a turning point. A disc: floor of a
/// goal's region, `radius` pixels.
std::string seen_mark(Point p);
std::string turning_mark(Point p);
std::string region_floor(Point p, double radius);
/// A ring, which leaves room for the goal in it.
std::string stop_mark(Point p, Colour colour);

/// A line of the legend.
std::string line_sample(std::string_view attributes);

enum class Anchor { kStart, kMiddle, kEnd };
std::string text(Point p, std::string_view content, double size, const char* colour,
                 bool bold = false, Anchor anchor = Anchor::kStart);

}  // namespace enfilade::draw::plan
