/// \file  Parts of all floor plans: the sheet, and panels with caption, floor and labels.
#pragma once
#include <string>

#include "enfilade/draw/plan/plan.h"

namespace enfilade::draw::plan {

inline constexpr double kBorder = 26;   ///< around everything, pixels
inline constexpr double kHeading = 62;  ///< title and subtitle
inline constexpr double kTitleSize = 21;
inline constexpr double kNarrowest = 560;  ///< room for a title and two columns of legend

/// Start of the document, with a group that sets the font; the caller closes `</g></svg>`.
std::string open_sheet(const std::string& title, Point size);

std::string draw_caption(const Plan& plan, const Panel& panel);
/// The shaded floor: discs around viewpoints and bands along edges in one colour, drawn twice, the
/// first time larger, for an outline.
std::string draw_floor(const Plan& plan, const Panel& panel);
/// Its index beside each viewpoint.
std::string draw_labels(const Plan& plan, const Panel& panel);

}  // namespace enfilade::draw::plan
