/// \file  Floor plan of the differences between two graphs of one building, as SVG.
#pragma once
#include <string>

#include "enfilade/graph/compare.h"
#include "enfilade/graph/nav_graph.h"

namespace enfilade::draw {

/// Texts on the drawing of two graphs.
struct ComparisonPlanOptions {
  std::string title;              ///< empty: the scan id
  std::string note;               ///< a paragraph below the numbers; may be empty
  bool label_viewpoints = false;  ///< their index beside each
};

/// Draws the viewpoints of `found`, one panel a storey. Edges of both graphs are grey, extra ones
/// red and solid, missing ones blue and dashed. Precision, recall and F1 are below the title. \pre
/// comparison is compare(found, ...) \throws ArgumentError if it holds a viewpoint that is not
/// below found.size()
std::string graph_comparison_svg(const graph::NavGraph& found,
                                 const graph::GraphComparison& comparison,
                                 const ComparisonPlanOptions& options = {});

}  // namespace enfilade::draw
