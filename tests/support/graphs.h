/// \file  Small graphs for tests, whose answers can be worked out by hand.
#pragma once
#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "enfilade/graph/graph_set.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::graph::testing {

/// Viewpoints "v0", "v1", ... at the given points, with the given undirected edges; level camera.
inline scan::Connectivity connectivity(const std::string& scan, const std::vector<Vec3d>& points,
                                       const std::vector<std::pair<int, int>>& edges) {
  scan::Connectivity c{scan, scan + "_connectivity.json", {}};
  for (std::size_t i = 0; i < points.size(); ++i) {
    scan::ConnectivityEntry entry;
    entry.id = "v" + std::to_string(i);
    // Columns: right = +x, down = -z, look = +y.
    entry.pose = {1, 0, 0, points[i].x, 0, 0, 1, points[i].y, 0, -1, 0, points[i].z, 0, 0, 0, 1};
    entry.height = 1.5;
    for (std::size_t j = 0; j < points.size(); ++j) {
      for (const auto& [a, b] : edges) {
        const auto from = static_cast<std::size_t>(a);
        const auto to = static_cast<std::size_t>(b);
        if ((from == i && to == j) || (from == j && to == i)) entry.unobstructed.emplace_back(j);
      }
    }
    entry.visible = entry.unobstructed;
    c.entries.push_back(entry);
  }
  return c;
}

/// A square of side 2 m, corners in the order (0,0) (2,0) (2,2) (0,2), at eye height 1.5 m.
inline scan::Connectivity square(const std::string& scan = "square") {
  return connectivity(scan, {{0, 0, 1.5}, {2, 0, 1.5}, {2, 2, 1.5}, {0, 2, 1.5}},
                      {{0, 1}, {1, 2}, {2, 3}, {3, 0}});
}

/// A grid of 3 x 3 viewpoints, 4 m apart: v0 v1 v2 to the east, v3 v4 v5 north of them, v6 v7 v8.
inline std::shared_ptr<const GraphSet> grid() {
  std::vector<Vec3d> points;
  std::vector<std::pair<int, int>> edges;
  for (int i = 0; i < 9; ++i) {
    points.push_back({4.0 * (i % 3), 4.0 * (i / 3), 1.5});
    if (i % 3 < 2) edges.emplace_back(i, i + 1);
    if (i < 6) edges.emplace_back(i, i + 3);
  }
  std::vector<NavGraph> graphs;
  graphs.emplace_back(connectivity("grid", points, edges));
  return GraphSet::of(std::move(graphs));
}

}  // namespace enfilade::graph::testing
