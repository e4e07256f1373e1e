/// \file  Paths on a floor plan, side by side where they use an edge more than once.
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
std::string draw_band(const Plan& plan, const Panel& panel, const std::vector<Step>& steps,
                      Colour colour);
/// The same as a line with an arrow on each step, from light to dark as time passes.
std::string draw_line(const Plan& plan, const Panel& panel, const std::vector<Step>& steps,
                      Colour colour);

inline constexpr double kBandWidth = 11;  ///< pixels
inline constexpr double kLineWidth = 3;

}  // namespace enfilade::draw::plan
