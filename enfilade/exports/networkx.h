/// \file  Navigation graphs and their shortest paths for code that uses networkx.
#pragma once
#include <memory>
#include <string>

#include "enfilade/exports/options.h"
#include "enfilade/graph/graph_set.h"

namespace enfilade::exports {

/// `{"<from>": {"<to>": metres}}` of all included viewpoints of a scan that reach each other, 0 for
/// itself; pairs out of reach are left out, as networkx does. JSON.
std::string all_distances(const graph::NavGraph& graph);
/// `{"<from>": {"<to>": ["<from>", ..., "<to>"]}}`, likewise. Among equally short paths that of
/// NavGraph::path(), which need not be networkx's.
std::string all_paths(const graph::NavGraph& graph);

/// VLN-CE's `connectivity_graphs.pkl`: a pickle (protocol 2) of `{"<scan>": networkx.Graph}`, with
/// included viewpoints as nodes. Loading needs networkx 2 or 3. Nodes have `position`, in Habitat's
/// frame as VLN-CE draws it ([x, z, -y] of the world frame), and `world_position` ([x, y, z]).
/// Edges have `weight`. All are metres. A scan with an edge in one direction only becomes a
/// networkx.DiGraph.
/// \throws FileError, InvalidInput for graphs that cannot be read
std::string connectivity_pickle(const graph::GraphSet& graphs);

}  // namespace enfilade::exports
