/// \file  The lower part of a floor plan: scale bar, north arrow, legend. Internal.
#pragma once
#include <string>
#include <vector>

#include "enfilade/draw/plan/svg.h"

namespace enfilade::draw::plan {

/// One entry of the legend: a sample, drawn around (0, 0), and its text.
struct LegendItem {
  std::string sample;
  double width = 0;  ///< of the sample, pixels
  std::string label;
};

/// SVG text and its height, pixels.
struct Block {
  std::string svg;
  double height = 0;
};

/// Scale bar and north arrow on the left, items beside them in as many rows as needed.
Block draw_legend(const std::vector<LegendItem>& items, Point corner, double width,
                  double pixels_per_metre);

}  // namespace enfilade::draw::plan
