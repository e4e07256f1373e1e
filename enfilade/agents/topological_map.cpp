#include "enfilade/agents/topological_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "enfilade/core/check.h"

namespace enfilade::agents {
namespace {

constexpr double kNoDistance = std::numeric_limits<double>::infinity();

// The simulator's positions are single precision: what agents measure with.
Vec3d widened(Vec3f v) { return {v.x, v.y, v.z}; }

double straight(const Vec3d& a, const Vec3d& b) {
  const double x = b.x - a.x, y = b.y - a.y, z = b.z - a.z;
  return std::sqrt(x * x + y * y + z * z);
}

}  // namespace

void TopologicalMap::clear() {
  nodes_.clear();
  pairs_.clear();
  visits_.clear();
  rows_.clear();
}

std::optional<TopologicalMap::Node> TopologicalMap::find(ViewpointIndex viewpoint) const {
  const auto found = std::ranges::find(nodes_, viewpoint, &Entry::viewpoint);
  if (found == nodes_.end()) return std::nullopt;
  return static_cast<Node>(found - nodes_.begin());
}

TopologicalMap::Node TopologicalMap::add(const graph::NavGraph& graph, ViewpointIndex viewpoint) {
  if (const auto known = find(viewpoint)) return *known;
  const auto node = static_cast<Node>(nodes_.size());
  nodes_.push_back({viewpoint, widened(graph.position(viewpoint))});
  pairs_.resize(pairs_.size() + node, {kNoDistance, kDirect});
  return node;
}

void TopologicalMap::arrive(const graph::NavGraph& graph, ViewpointIndex here,
                            std::span<const sim::Candidate> candidates, std::uint32_t step) {
  const Node at = add(graph, here);
  for (const sim::Candidate& candidate : candidates) {
    const Node to = add(graph, candidate.viewpoint);
    if (to == at) continue;
    const double length = straight(nodes_[at].position, nodes_[to].position);
    Pair& known = pair(at, to);
    if (length < known.distance) known = {length, kDirect};
  }
  relax(at);
  if (!nodes_[at].visited) {
    nodes_[at].visited = true;
    visits_.push_back(at);
  }
  nodes_[at].step_id = step + 1;
  rows_.clear();
  for (const bool visited : {true, false}) {
    for (Node node = 0; node < nodes_.size(); ++node) {
      if (nodes_[node].visited == visited) rows_.push_back(node);
    }
  }
}

void TopologicalMap::relax(Node through) {
  for (Node a = 1; a < nodes_.size(); ++a) {
    if (a == through) continue;
    const double first = pair(a, through).distance;
    if (first == kNoDistance) continue;
    for (Node b = 0; b < a; ++b) {
      if (b == through) continue;
      const double sum = first + pair(through, b).distance;
      if (sum < pair(a, b).distance) pair(a, b) = {sum, through};
    }
  }
}

template <class Use>
void TopologicalMap::unfold(Node a, Node b, const Use& use) const {
  const Node middle = pair(a, b).middle;
  if (middle == kDirect) {
    use(b);
  } else {
    unfold(a, middle, use);
    unfold(middle, b, use);
  }
}

void TopologicalMap::path(Node a, Node b, std::vector<ViewpointIndex>& out) const {
  out.clear();
  if (a == b) return;
  EN_CHECK(distance(a, b) < kNoDistance);
  unfold(a, b, [&](Node node) { out.push_back(nodes_[node].viewpoint); });
}

std::size_t TopologicalMap::hops(Node a, Node b) const {
  std::size_t count = 0;
  if (a != b) unfold(a, b, [&](Node) { ++count; });
  return count;
}

MapFeature map_feature(const TopologicalMap& map, TopologicalMap::Node from,
                       TopologicalMap::Node to, Radians heading, Radians elevation) {
  constexpr double kLeast = 1e-8;  // metres
  constexpr double kFar = 30, kMany = 10;
  const Vec3d a = map.position(from), b = map.position(to);
  const double x = b.x - a.x, y = b.y - a.y, z = b.z - a.z;
  const double flat = std::max(std::sqrt(x * x + y * y), kLeast);
  const double line = std::max(std::sqrt(x * x + y * y + z * z), kLeast);
  double right = std::asin(x / flat);
  if (b.y < a.y) right = std::numbers::pi - right;
  const auto h = static_cast<float>(right - heading.value);
  const auto e = static_cast<float>(std::asin(z / line) - elevation.value);
  return {std::sin(h),
          std::cos(h),
          std::sin(e),
          std::cos(e),
          static_cast<float>(line / kFar),
          static_cast<float>(map.distance(from, to) / kFar),
          static_cast<float>(static_cast<double>(map.hops(from, to)) / kMany)};
}

void StopMemory::remember(Node node, double probability) {
  const auto known = std::ranges::find(known_, node, &std::pair<Node, double>::first);
  if (known == known_.end()) {
    known_.emplace_back(node, probability);
  } else {
    known->second = probability;
  }
}

std::optional<StopMemory::Node> StopMemory::best() const {
  const auto best = std::ranges::max_element(known_, {}, &std::pair<Node, double>::second);
  if (best == known_.end()) return std::nullopt;
  return best->first;
}

void final_walk(const TopologicalMap& map, TopologicalMap::Node here, const StopMemory& memory,
                LastAction last, FinalStop rule, std::vector<ViewpointIndex>& out) {
  out.clear();
  if (rule == FinalStop::kUnlessOwn && last == LastAction::kStop) return;
  if (const auto best = memory.best()) map.path(here, *best, out);
}

}  // namespace enfilade::agents
