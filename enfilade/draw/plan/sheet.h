/// \file  The sheet of a floor plan: title, panels with caption, floor, walls and labels, legend.
#pragma once
#include <string>
#include <vector>

#include "enfilade/draw/plan/plan.h"
#include "enfilade/draw/plan_underlay.h"

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
std::string draw_sheet(const Sheet& sheet, const PanelLayout& layout, const std::string& panels);

std::string draw_caption(const StoreyPlan& plan, const Panel& panel);
/// The shaded floor: discs around viewpoints and bands along edges in one colour, drawn twice, the
/// first time larger, for an outline.
std::string draw_floor(const StoreyPlan& plan, const Panel& panel);
/// Its index beside each viewpoint.
std::string draw_labels(const StoreyPlan& plan, const Panel& panel);

/// Walls, doors, windows and stairs; names.
std::string draw_lines(const UnderlayStorey& storey, const Panel& panel);
std::string draw_texts(const UnderlayStorey& storey, const Panel& panel);

/// Legend of the kinds of lines in the underlay.
std::vector<LegendItem> underlay_legend(const PlanUnderlay& underlay);

}  // namespace enfilade::draw::plan
