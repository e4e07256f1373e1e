/// \file  The sheet of a floor plan: title, panels with caption, floor and labels, legend.
#pragma once
#include <string>
#include <vector>

#include "enfilade/draw/plan/plan.h"

namespace enfilade::draw::plan {

/// One entry of the legend: a sample, drawn around (0, 0), and its text.
struct LegendItem {
  std::string sample;
  double width = 0;  ///< of the sample, pixels
  std::string label;
};

/// Texts around the panels.
struct Sheet {
  std::string title, subtitle;
  std::vector<std::string> notes;  ///< paragraphs below them
  std::vector<LegendItem> legend;
  bool rule = false;  ///< whether a line parts the legend from the panels
};

/// The SVG document. \param panels SVG of all panels, in the layout's coordinates
std::string draw_sheet(const Sheet& sheet, const Layout& layout, const std::string& panels);

std::string draw_caption(const Plan& plan, const Panel& panel);
/// The shaded floor: discs around viewpoints and bands along edges in one colour, drawn twice, the
/// first time larger, for an outline.
std::string draw_floor(const Plan& plan, const Panel& panel);
/// Its index beside each viewpoint.
std::string draw_labels(const Plan& plan, const Panel& panel);

}  // namespace enfilade::draw::plan
