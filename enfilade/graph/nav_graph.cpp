#include "enfilade/graph/nav_graph.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <functional>
#include <limits>
#include <mutex>
#include <unordered_map>

#define NANOFLANN_FIRST_MATCH  // equally near points: the one of the lower index
#include <fmt/format.h>
#include <nanoflann.hpp>

#include "enfilade/core/check.h"
#include "enfilade/core/errors.h"

namespace enfilade::graph {
namespace {

// The included viewpoints, with the interface that nanoflann needs.
struct Cloud {
  std::vector<Vec3f> points;
  std::vector<ViewpointIndex> viewpoints;

  std::size_t kdtree_get_point_count() const { return points.size(); }
  float kdtree_get_pt(std::size_t i, std::size_t axis) const {
    const Vec3f& p = points[i];
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
  }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};

using Tree = nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, Cloud, double>,
                                                 Cloud, 3, std::uint32_t>;

// The order of operations is MatterSim's, which recorded bits depend on (docs/graph.md).
Edge make_edge(Vec3d from_exact, Vec3d to_exact, ViewpointIndex target) {
  const Vec3f offset = to_float(to_exact) - to_float(from_exact);
  const float squared = offset.x * offset.x + offset.y * offset.y;
  const float inverse = 1.0F / std::sqrt(squared);
  Edge edge;
  edge.target = target;
  edge.dx = offset.x;
  edge.dy = offset.y;
  // Straight above or below there is no horizontal direction. 0 * inf would be NaN too; this makes
  // it explicit.
  edge.unit_x = squared > 0 ? offset.x * inverse : std::numeric_limits<float>::quiet_NaN();
  edge.unit_y = squared > 0 ? offset.y * inverse : std::numeric_limits<float>::quiet_NaN();
  edge.distance = length(offset);
  edge.heading = wrap_heading(Radians(std::atan2(static_cast<double>(offset.x), offset.y)));
  edge.elevation = Radians(std::atan2(static_cast<double>(offset.z), std::sqrt(squared)));
  edge.length = length(to_exact - from_exact);
  return edge;
}

// A node, and how far it is.
struct Reached {
  double distance;
  std::uint32_t node;
  friend bool operator>(const Reached& a, const Reached& b) {
    return a.distance != b.distance ? a.distance > b.distance : a.node > b.node;
  }
};

}  // namespace

ShortestPaths::ShortestPaths(std::span<const std::uint32_t> first,
                             std::span<const WeightedTarget> targets)
    : n_(first.size() - 1),
      distances_(n_ * n_, std::numeric_limits<double>::infinity()),
      before_(n_ * n_, kNone) {
  EN_CHECK_LT(n_, std::size_t{kNone});
  std::vector<Reached> heap;
  for (std::size_t source = 0; source < n_; ++source) {
    double* distance = &distances_[source * n_];
    std::uint16_t* before = &before_[source * n_];
    distance[source] = 0;
    heap.push_back({0, static_cast<std::uint32_t>(source)});
    while (!heap.empty()) {
      std::ranges::pop_heap(heap, std::greater<>());
      const Reached here = heap.back();
      heap.pop_back();
      if (here.distance > distance[here.node]) continue;  // reached on a shorter way since
      for (const WeightedTarget& edge :
           targets.subspan(first[here.node], first[here.node + 1] - first[here.node])) {
        const double through = here.distance + edge.weight;
        if (through < distance[edge.target]) {
          distance[edge.target] = through;
          before[edge.target] = static_cast<std::uint16_t>(here.node);
          heap.push_back({through, edge.target});
          std::ranges::push_heap(heap, std::greater<>());
        } else if (through == distance[edge.target] && here.node < before[edge.target] &&
                   edge.weight > 0 && edge.target != source) {
          before[edge.target] = static_cast<std::uint16_t>(here.node);
        }
      }
    }
  }
}

struct NavGraph::Lazy {
  std::unordered_map<std::string_view, ViewpointIndex> by_id;
  std::atomic<const ShortestPaths*> ready_paths = nullptr;
  std::mutex paths_mutex;
  std::optional<ShortestPaths> paths;
  std::once_flag tree_once;
  Cloud cloud;
  std::optional<Tree> tree;

  // Not std::call_once, which writes thread-local variables at every call. In a shared library, or
  // linked by mold 1.10, these are a function call, and scoring took 1.8 times as long.
  const ShortestPaths& shortest(const NavGraph& graph) {
    const ShortestPaths* const ready = ready_paths.load(std::memory_order_acquire);
    return ready != nullptr ? *ready : make_paths(graph);
  }

  const ShortestPaths& make_paths(const NavGraph& graph) {
    const std::scoped_lock lock(paths_mutex);
    if (!paths) {
      std::vector<WeightedTarget> targets;
      targets.reserve(graph.edges_.size());
      for (const Edge& edge : graph.edges_) targets.push_back({edge.target.value, edge.length});
      paths.emplace(graph.first_edge_, targets);
      ready_paths.store(&*paths, std::memory_order_release);
    }
    return *paths;
  }

  const Tree& nearest(const NavGraph& graph) {
    std::call_once(tree_once, [&] {
      for (std::size_t i = 0; i < graph.size(); ++i) {
        if (!graph.included(ViewpointIndex(i))) continue;
        cloud.points.push_back(graph.positions_[i]);
        cloud.viewpoints.emplace_back(i);
      }
      tree.emplace(3, cloud);
      tree->buildIndex();
    });
    return *tree;
  }
};

NavGraph::NavGraph(const scan::Connectivity& connectivity)
    : scan_(connectivity.scan), lazy_(std::make_unique<Lazy>()) {
  const std::size_t n = connectivity.entries.size();
  if (n >= ShortestPaths::kNone) {
    throw ArgumentError(fmt::format("scan {}: {} viewpoints; at most {} are supported", scan_, n,
                                    ShortestPaths::kNone - 1));
  }
  ids_.reserve(n);  // by_id points into it
  lazy_->by_id.reserve(n);
  first_edge_.reserve(n + 1);
  for (const scan::ConnectivityEntry& entry : connectivity.entries) {
    const ViewpointIndex index(ids_.size());
    lazy_->by_id.emplace(ids_.emplace_back(entry.id), index);
    positions_.push_back(to_float(entry.position()));
    heights_.push_back(static_cast<float>(entry.height));
    included_.push_back(entry.included ? 1 : 0);
    included_count_ += entry.included ? 1 : 0;
  }
  for (std::size_t i = 0; i < n; ++i) {
    first_edge_.push_back(static_cast<std::uint32_t>(edges_.size()));
    const scan::ConnectivityEntry& from = connectivity.entries[i];
    if (!from.included) continue;
    for (const ViewpointIndex j : from.unobstructed) {
      const scan::ConnectivityEntry& to = connectivity.entries[j.at()];
      if (!to.included || j.at() == i) continue;
      edges_.push_back(make_edge(from.position(), to.position(), j));
    }
    max_degree_ = std::max(max_degree_, edges_.size() - first_edge_.back());
  }
  first_edge_.push_back(static_cast<std::uint32_t>(edges_.size()));
}

NavGraph::~NavGraph() = default;
NavGraph::NavGraph(NavGraph&&) noexcept = default;
NavGraph& NavGraph::operator=(NavGraph&&) noexcept = default;

std::optional<ViewpointIndex> NavGraph::find(std::string_view id) const {
  const auto found = lazy_->by_id.find(id);
  if (found == lazy_->by_id.end()) return std::nullopt;
  return found->second;
}

const Edge* NavGraph::edge(ViewpointIndex a, ViewpointIndex b) const {
  for (const Edge& edge : edges(a)) {
    if (edge.target == b) return &edge;
  }
  return nullptr;
}

double NavGraph::distance(ViewpointIndex a, ViewpointIndex b) const {
  return lazy_->shortest(*this).distance(a.at(), b.at());
}

std::optional<ViewpointIndex> NavGraph::before(ViewpointIndex a, ViewpointIndex b) const {
  const std::uint16_t node = lazy_->shortest(*this).before(a.at(), b.at());
  if (node == ShortestPaths::kNone) return std::nullopt;
  return ViewpointIndex(node);
}

std::optional<std::vector<ViewpointIndex>> NavGraph::path(ViewpointIndex a,
                                                          ViewpointIndex b) const {
  std::vector<ViewpointIndex> reversed{b};
  while (reversed.back() != a) {
    const auto previous = before(a, reversed.back());
    if (!previous) return std::nullopt;
    reversed.push_back(*previous);
    EN_CHECK_LE(reversed.size(), size());
  }
  std::ranges::reverse(reversed);
  return reversed;
}

std::optional<ViewpointIndex> NavGraph::nearest(Vec3f point) const {
  if (!std::isfinite(point.x) || !std::isfinite(point.y) || !std::isfinite(point.z)) {
    return std::nullopt;
  }
  const Tree& tree = lazy_->nearest(*this);
  const std::array<float, 3> query{point.x, point.y, point.z};
  std::uint32_t index = 0;
  double squared = 0;
  if (tree.knnSearch(query.data(), 1, &index, &squared) == 0) return std::nullopt;
  return lazy_->cloud.viewpoints[index];
}

}  // namespace enfilade::graph
