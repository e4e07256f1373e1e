/// \file  Where two graphs of one building differ, drawn on its floor plan as SVG.
#pragma once
#include <string>

#include "enfilade/graph/compare.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::draw {

struct ComparisonPlanOptions {
  std::string title;              ///< empty: the scan id
  std::string note;               ///< a line below the figures; may be empty
  bool label_viewpoints = false;  ///< their index beside each
};

/// The viewpoints of `found`, a panel a storey; edges in both grey, extra ones red and solid,
/// missing ones blue and dashed. Precision, recall and F1 stand below the title.
/// \pre comparison is compare(found, ...)
/// \throws ArgumentError if it holds a viewpoint that is not below found.size()
std::string graph_comparison_svg(const graph::NavGraph& found,
                                 const graph::GraphComparison& comparison,
                                 const ComparisonPlanOptions& options = {});

}  // namespace enfilade::draw
