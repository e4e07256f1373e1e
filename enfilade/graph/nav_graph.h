/// \file  Viewpoints of one scan and the navigable edges between them.
#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/geometry/angle.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/scan/connectivity.h"

namespace enfilade::graph {

/// Measures of a step from one viewpoint to a neighbour, computed once. Single precision where
/// MatterSim has it, because recorded behaviour depends on the bits.
struct Edge {
  ViewpointIndex target;
  float dx = 0, dy = 0;          ///< horizontal offset, metres, world frame
  float unit_x = 0, unit_y = 0;  ///< the same, of length 1; NaN if straight above or below
  float distance = 0;            ///< straight line in 3-D, metres
  Radians heading;               ///< world heading towards the target, [0, 2 pi)
  Radians elevation;             ///< above the horizon, [-pi/2, pi/2]
  double length = 0;             ///< as distance, from double-precision positions
};

/// One end of a weighted edge in compressed rows.
struct WeightedTarget {
  std::uint32_t target = 0;
  double weight = 0;  ///< >= 0
};

/// Distances and predecessors between all pairs of n nodes. Deterministic: among paths of equal
/// length (to the bit, summed from the source), the one whose last differing node has the lower
/// index. Immutable; 10 n^2 bytes.
class ShortestPaths {
 public:
  static constexpr std::uint16_t kNone = 0xffff;

  /// Dijkstra from each node, O(n m log n). `first` holds n + 1 offsets into `targets`.
  /// \pre n < 65535
  ShortestPaths(std::span<const std::uint32_t> first, std::span<const WeightedTarget> targets);

  /// Length of the shortest path; +inf if b is out of reach. O(1). \pre a, b < n
  double distance(std::size_t a, std::size_t b) const { return distances_[a * n_ + b]; }
  /// The node before b on the path from a; kNone if a == b or b is out of reach.
  std::uint16_t before(std::size_t a, std::size_t b) const { return before_[a * n_ + b]; }

 private:
  std::size_t n_;
  std::vector<double> distances_;
  std::vector<std::uint16_t> before_;
};

/// Directed graph over the n viewpoints of one scan (all 90 graphs of Matterport3D are symmetric).
/// Viewpoints keep their index in the connectivity file, excluded ones included, so an index is
/// MatterSim's `ix`. An edge leads from i to j if both are included and row i of `unobstructed` has
/// it; nothing is symmetrised. Immutable, so any number of threads may read it; owns its storage:
/// spans and string_views are valid as long as *this. Lengths in metres, positions in the world
/// frame. Functions of a ViewpointIndex have the precondition that it is below size().
class NavGraph {
 public:
  /// O(n^2) in the file's flags. Shortest paths and look-up by position are made at first use.
  explicit NavGraph(const scan::Connectivity& connectivity);
  ~NavGraph();
  NavGraph(NavGraph&&) noexcept;
  NavGraph& operator=(NavGraph&&) noexcept;

  const std::string& scan() const noexcept { return scan_; }
  std::size_t size() const noexcept { return ids_.size(); }  ///< n, excluded ones counted
  std::size_t included_count() const noexcept { return included_count_; }
  std::size_t edge_count() const noexcept { return edges_.size(); }  ///< directed
  std::size_t max_degree() const noexcept { return max_degree_; }

  /// Whether agents may stand there.
  bool included(ViewpointIndex v) const { return included_[v.at()] != 0; }
  /// The viewpoint's id in the files of its scan.
  const std::string& id(ViewpointIndex v) const { return ids_[v.at()]; }
  /// By id, excluded ones too; O(1).
  std::optional<ViewpointIndex> find(std::string_view id) const;
  Vec3f position(ViewpointIndex v) const { return positions_[v.at()]; }
  std::span<const Vec3f> positions() const noexcept { return positions_; }  ///< shape (n)
  float height(ViewpointIndex v) const { return heights_[v.at()]; }  ///< above the floor, metres

  /// Steps that lead away from v, targets ascending. Empty if v is excluded.
  std::span<const Edge> edges(ViewpointIndex v) const {
    return std::span(edges_).subspan(first_edge_[v.at()],
                                     first_edge_[v.at() + 1] - first_edge_[v.at()]);
  }
  /// The edge a -> b, or null. O(degree).
  const Edge* edge(ViewpointIndex a, ViewpointIndex b) const;

  /// Shortest distance along edges; 0 for a == b, +inf if out of reach. O(1) after the first call
  /// on this graph, which computes all pairs (Dijkstra, about 2 ms for 117 viewpoints).
  double distance(ViewpointIndex a, ViewpointIndex b) const;
  /// The path behind distance(), both ends included; no value if b is out of reach. Among equally
  /// short paths, the one whose viewpoints, read from the end, have the lower indices. So equal
  /// graphs give equal paths on every platform.
  std::optional<std::vector<ViewpointIndex>> path(ViewpointIndex a, ViewpointIndex b) const;
  /// The viewpoint before b on path(a, b). No value if a == b or b is out of reach. O(1).
  std::optional<ViewpointIndex> before(ViewpointIndex a, ViewpointIndex b) const;

  /// The included viewpoint nearest to a point (k-d tree); of equally near ones that of the lower
  /// index. No value if the graph has no included viewpoint or a coordinate is not finite.
  std::optional<ViewpointIndex> nearest(Vec3f point) const;

 private:
  struct Lazy;

  std::string scan_;
  std::vector<std::string> ids_;
  std::vector<Vec3f> positions_;
  std::vector<float> heights_;
  std::vector<char> included_;
  std::vector<std::uint32_t> first_edge_;  // n + 1: edges of v are [first_edge_[v], [v + 1])
  std::vector<Edge> edges_;
  std::size_t included_count_ = 0;
  std::size_t max_degree_ = 0;
  std::unique_ptr<Lazy> lazy_;
};

}  // namespace enfilade::graph
