/// \file  What all floor plans have: a sheet, and panels with caption, floor and labels. Internal.
#pragma once
#include <string>

#include "enfilade/draw/plan/plan.h"

namespace enfilade::draw::plan {

inline constexpr double kBorder = 26;   ///< around everything, pixels
inline constexpr double kHeading = 62;  ///< title and subtitle
inline constexpr double kTitleSize = 21;
inline constexpr double kNarrowest = 560;  ///< room for a title and two columns of legend

/// The document's begin, up to a group with the texts' font; the caller closes `</g></svg>`.
std::string open_sheet(const std::string& title, Point size);

std::string draw_caption(const Plan& plan, const Panel& panel);
/// Discs around the viewpoints and bands along the edges, in one colour, run together to a shape
/// that looks like the floor; drawn twice, a little larger the first time, for its rim.
std::string draw_floor(const Plan& plan, const Panel& panel);
/// Its index beside each viewpoint.
std::string draw_labels(const Plan& plan, const Panel& panel);

}  // namespace enfilade::draw::plan
