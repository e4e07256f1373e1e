/// \file  Walls, doors, windows, stairs and names below a floor plan's graph.
#pragma once
#include <string>
#include <vector>

#include "enfilade/draw/plan/sheet.h"
#include "enfilade/draw/plan_underlay.h"

namespace enfilade::draw::plan {

std::string draw_lines(const UnderlayStorey& storey, const Panel& panel);
std::string draw_texts(const UnderlayStorey& storey, const Panel& panel);

/// Legend of the kinds of lines in the underlay.
std::vector<LegendItem> underlay_legend(const PlanUnderlay& underlay);

}  // namespace enfilade::draw::plan
