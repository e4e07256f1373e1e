/// \file  Shortest paths of navigation graphs, as code that uses networkx stores them.
#pragma once
#include <string>

#include "enfilade/graph/nav_graph.h"

namespace enfilade::exports {

/// `{"<from>": {"<to>": metres}}` of all included viewpoints of a scan that reach each other, 0 for
/// itself; pairs out of reach are left out, as networkx does. JSON.
std::string all_distances(const graph::NavGraph& graph);
/// `{"<from>": {"<to>": ["<from>", ..., "<to>"]}}`, likewise. A path is
/// NavGraph::path(); networkx may choose another equally short one.
std::string all_paths(const graph::NavGraph& graph);

}  // namespace enfilade::exports
