/// \file  An agent's map: its visited viewpoints, and the ones seen from them. Where on it an agent
/// ends.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "enfilade/core/ids.h"
#include "enfilade/geometry/vec.h"
#include "enfilade/graph/nav_graph.h"
#include "enfilade/sim/candidates.h"

namespace enfilade::agents {

/// The topological map of DUET (Chen et al., CVPR 2022, section 3.1). Nodes are all viewpoints seen
/// so far, in the order of first sight; edges lead from visited nodes to their neighbours. Known
/// paths run through visited nodes only. A plain value; clear() keeps its memory, so that after the
/// first episodes nothing allocates. One thread at a time.
class TopologicalMap {
 public:
  /// A node by its index in the order of first sight.
  using Node = std::uint32_t;

  void clear();  ///< no node is left

  /// Adds the candidates in view when the agent arrives at `here` at its step `step`. New ones are
  /// added in their order, with edges of straight length (kept if shorter than the known one). Then
  /// relaxes all pairs through `here`, which is visited from now on.
  /// \param candidates as CandidateFinder gives them
  /// \pre all are viewpoints of `graph`
  void arrive(const graph::NavGraph& graph, ViewpointIndex here,
              std::span<const sim::Candidate> candidates, std::uint32_t step);

  std::size_t size() const noexcept { return nodes_.size(); }                   ///< nodes
  ViewpointIndex viewpoint(Node node) const { return nodes_[node].viewpoint; }  ///< of a node
  std::optional<Node> find(ViewpointIndex viewpoint) const;       ///< its node, if it has been seen
  bool visited(Node node) const { return nodes_[node].visited; }  ///< or only seen
  /// 0 while open; of a visited node the step of its last visit + 1.
  std::uint32_t step_id(Node node) const { return nodes_[node].step_id; }
  Vec3d position(Node node) const { return nodes_[node].position; }  ///< metres, world
  /// Nodes that are not visited.
  std::size_t open() const noexcept { return nodes_.size() - visits_.size(); }
  /// Visited nodes, in the order of their first visits.
  std::span<const Node> visits() const noexcept { return visits_; }
  /// Visited nodes, then open ones, both in the order of first sight: the rows of DUET's global
  /// branch behind its [stop]. Valid until the next arrive() or clear().
  std::span<const Node> rows() const noexcept { return rows_; }

  /// Length of the shortest known path, metres; 0 for a == b, +inf if none is known.
  double distance(Node a, Node b) const { return a == b ? 0 : pair(a, b).distance; }
  /// The known path from a to b without a; empty for a == b. \pre distance(a, b) is finite
  void path(Node a, Node b, std::vector<ViewpointIndex>& out) const;
  /// The number of viewpoints of path(). \pre as there
  std::size_t hops(Node a, Node b) const;

 private:
  static constexpr Node kDirect = 0xffffffff;
  struct Entry {
    ViewpointIndex viewpoint;
    Vec3d position;
    bool visited = false;
    std::uint32_t step_id = 0;
  };
  struct Pair {
    double distance;
    Node middle;  // kDirect, or a node that the path runs through
  };
  Node add(const graph::NavGraph& graph, ViewpointIndex viewpoint);
  // Index of a pair in the triangle below the diagonal.
  static std::size_t place(Node a, Node b) {
    const std::size_t high = a > b ? a : b, low = a > b ? b : a;
    return high * (high - 1) / 2 + low;
  }
  const Pair& pair(Node a, Node b) const { return pairs_[place(a, b)]; }
  Pair& pair(Node a, Node b) { return pairs_[place(a, b)]; }
  void relax(Node through);
  template <class Use>
  void unfold(Node a, Node b, const Use& use) const;

  std::vector<Entry> nodes_;
  std::vector<Pair> pairs_;
  std::vector<Node> visits_, rows_;
};

/// DUET's position features: [sin h, cos h, sin e, cos e, straight line / 30 m, distance along the
/// map / 30 m, viewpoints on the way / 10]. Angles h and e are relative to the agent.
using MapFeature = std::array<float, 7>;

/// Feature of [stop], which has no position.
inline constexpr MapFeature kStopFeature{0, 1, 0, 1, 0, 0, 0};

/// Feature of `to`, from an agent at `from` with direction `heading` and `elevation`. Angles are
/// rounded to single precision before sine and cosine, as in the released code.
MapFeature map_feature(const TopologicalMap& map, TopologicalMap::Node from,
                       TopologicalMap::Node to, Radians heading, Radians elevation);

/// Why an agent has chosen its last action.
enum class LastAction {
  kStop,         ///< it stopped by itself
  kNothingOpen,  ///< no open node was left to go to
  kLimit,        ///< the most actions that an episode may have are used up
};

/// When an agent, after its last action, goes back to the viewpoint where stopping was most
/// probable.
enum class FinalStop {
  kAlways,     ///< the released DUET: also after a stop of its own
  kUnlessOwn,  ///< where it stopped by itself it stays; else as above
};

/// How probable stopping was at each place that an agent has visited. clear() keeps the memory.
class StopMemory {
 public:
  using Node = TopologicalMap::Node;  ///< of the map

  void clear() { known_.clear(); }  ///< forgets all
  /// The probability of stopping at the agent's node. An earlier one of the same node is replaced,
  /// at its old position in the order.
  void remember(Node node, double probability);
  /// The node with the highest probability, the first remembered of equals. No value: none is
  /// known.
  std::optional<Node> best() const;

 private:
  std::vector<std::pair<Node, double>> known_;
};

/// The path after the last action: to memory.best() along known edges, without `here`; empty if the
/// agent stays.
/// \pre `here` and all nodes of the memory are nodes of the map
void final_walk(const TopologicalMap& map, TopologicalMap::Node here, const StopMemory& memory,
                LastAction last, FinalStop rule, std::vector<ViewpointIndex>& out);

}  // namespace enfilade::agents
