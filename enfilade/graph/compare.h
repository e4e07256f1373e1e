/// \file  How far two graphs of one building agree.
#pragma once
#include <string>
#include <utility>
#include <vector>

#include "enfilade/graph/nav_graph.h"

namespace enfilade::graph {

/// An edge that only one of two graphs has.
struct ComparedEdge {
  ViewpointIndex a, b;  ///< of the found graph; a < b
  double length = 0;    ///< metres
};

/// `found` against `truth`, edges as undirected pairs of included viewpoints. Viewpoints are
/// matched by id, or, if no id is in both, each to the nearest within half a metre, one to one.
struct GraphComparison {
  std::size_t matched = 0;                          ///< viewpoints
  std::vector<std::string> only_found, only_truth;  ///< ids that have no partner
  std::size_t common = 0;                           ///< edges in both
  std::vector<ComparedEdge> extra;                  ///< found, not in truth
  std::vector<ComparedEdge> missing;                ///< in truth, not found
  double precision() const noexcept;                ///< 1 if nothing was found
  double recall() const noexcept;                   ///< 1 if truth has none
  double f1() const noexcept;
};
/// \throws ArgumentError if no viewpoint can be matched
GraphComparison compare(const NavGraph& found, const NavGraph& truth);

}  // namespace enfilade::graph
