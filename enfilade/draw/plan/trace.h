/// \file  Paths over a floor plan, kept apart where they run over one edge twice. Internal.
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

/// The steps of each path, those that stay where they are left out. A step over an edge that is
/// used once in all the paths runs down its middle; others keep to the right, the second one in a
/// direction further out than the first, `spacing` pixels apart or less if there are many: like
/// traffic.
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
