#include "enfilade/graph/shortest_paths.h"

#include <algorithm>
#include <functional>
#include <limits>

#include "enfilade/core/check.h"

namespace enfilade::graph {
namespace {

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

}  // namespace enfilade::graph
