/// \file  Other code's tables of navigation graphs: which viewpoints are reachable from a
/// viewpoint, in which view, and by which path. Texts in JSON; docs/exports.md has each form.
#pragma once
#include <memory>
#include <string>

#include "enfilade/exports/options.h"
#include "enfilade/graph/graph_set.h"

namespace enfilade::exports {

// All these have the included viewpoints of every scan, in the order of the graphs. Neighbours
// come in the order in which turning through the 36 views meets them (sim::CandidateFinder, with
// the camera of Room-to-Room: 640 x 480, 60 degrees). Angles are radians; numbers read back to the
// bit. `options.progress` counts scans. All throw FileError and InvalidInput for graphs that cannot
// be read.

/// DUET's `scanvp_candview_relangles.json`: `{"<scan>_<viewpoint>": {"<neighbour>": [view, angle,
/// rel_heading, rel_elevation]}}`. The view is that which has the neighbour nearest to its middle,
/// the angles are from that middle, `angle` is sqrt(rel_heading^2 + rel_elevation^2).
std::string duet_candidates(const std::shared_ptr<const graph::GraphSet>& graphs,
                            const ExportOptions& options = {});

/// LangNav's and NavCoT's `adj_loc_dict.json`: `{"<scan>_<viewpoint>": [{"viewpointId": ...,
/// "pointId": ..., ...}]}`. Each entry has the fields of EnvDrop's candidates:
/// - `scanId`, `viewpointId`, `pointId` (the view), `idx` (in that view's navigable list)
/// - `distance` (the angle, radians), `position` (metres)
/// - `heading` and `normalized_heading` ([0, 2 pi], world), `elevation`
std::string langnav_adjacency(const std::shared_ptr<const graph::GraphSet>& graphs,
                              const ExportOptions& options = {});

/// NavGPT's `<scan>_navigable.json`: `{"<viewpoint>": {"<neighbour>": {"heading": ...,
/// "elevation": ..., "distance": ...}}}`. World angles, heading in [0, 2 pi]; metres in a straight
/// line. \pre scan < graphs->size()
std::string navgpt_navigable(const std::shared_ptr<const graph::GraphSet>& graphs, ScanIndex scan);

/// GridMM's `viewpoint_info.json`: `{"<scan>_<viewpoint>": {"x": ..., "y": ..., "z": ...}}`,
/// metres, world frame.
std::string gridmm_viewpoints(const std::shared_ptr<const graph::GraphSet>& graphs,
                              const ExportOptions& options = {});

// The tables of a scan that code with networkx stores, and what its graph is made of.

/// `{"<from>": {"<to>": metres}}` of all included viewpoints of a scan that reach each other, 0 for
/// itself; pairs out of reach are left out, as networkx does. JSON.
std::string all_distances(const graph::NavGraph& graph);
/// `{"<from>": {"<to>": ["<from>", ..., "<to>"]}}`, likewise. A path is
/// NavGraph::path(); networkx may choose another equally short one.
std::string all_paths(const graph::NavGraph& graph);
/// `{"<viewpoint>": {"position": [x, y, z], "edges": {"<neighbour>": metres}}}`, world frame. JSON.
std::string all_edges(const graph::NavGraph& graph);

}  // namespace enfilade::exports
