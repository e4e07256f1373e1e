/// \file  All-pairs shortest paths of a sparse graph.
#pragma once
#include <cstdint>
#include <span>
#include <vector>

namespace enfilade::graph {

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

}  // namespace enfilade::graph
