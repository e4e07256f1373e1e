#include "enfilade/graph/nav_graph.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "enfilade/core/rng.h"

namespace enfilade::graph {
namespace EN_UNIT {

struct Rows {
  std::vector<std::uint32_t> first;
  std::vector<WeightedTarget> targets;
};

Rows random_rows(std::size_t n, Rng& rng) {
  Rows rows;
  for (std::size_t i = 0; i < n; ++i) {
    rows.first.push_back(static_cast<std::uint32_t>(rows.targets.size()));
    for (std::uint32_t j = 0; j < n; ++j) {
      // Whole numbers, so that many paths tie and sums are exact.
      if (j != i && rng.below(4) == 0) {
        rows.targets.push_back({j, static_cast<double>(1 + rng.below(4))});
      }
    }
  }
  rows.first.push_back(static_cast<std::uint32_t>(rows.targets.size()));
  return rows;
}

// The oracle: Floyd and Warshall's three loops.
std::vector<double> floyd_warshall(const Rows& rows, std::size_t n) {
  std::vector<double> d(n * n, std::numeric_limits<double>::infinity());
  for (std::size_t i = 0; i < n; ++i) {
    d[i * n + i] = 0;
    for (std::uint32_t e = rows.first[i]; e < rows.first[i + 1]; ++e) {
      d[i * n + rows.targets[e].target] = rows.targets[e].weight;
    }
  }
  for (std::size_t k = 0; k < n; ++k) {
    for (std::size_t i = 0; i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        d[i * n + j] = std::min(d[i * n + j], d[i * n + k] + d[k * n + j]);
      }
    }
  }
  return d;
}

TEST(ShortestPaths, AgreeWithFloydWarshallAndTieToLowerIndices) {
  for (std::uint64_t seed = 0; seed < 30; ++seed) {
    Rng rng(seed);
    const std::size_t n = 2 + rng.below(14);
    const Rows rows = random_rows(n, rng);
    const ShortestPaths paths(rows.first, rows.targets);
    const std::vector<double> truth = floyd_warshall(rows, n);
    for (std::size_t a = 0; a < n; ++a) {
      for (std::size_t b = 0; b < n; ++b) {
        ASSERT_EQ(paths.distance(a, b), truth[a * n + b]) << seed << ": " << a << " to " << b;
        std::uint16_t lowest = ShortestPaths::kNone;
        for (std::size_t u = 0; u < n && a != b; ++u) {
          for (std::uint32_t e = rows.first[u]; e < rows.first[u + 1]; ++e) {
            const WeightedTarget& edge = rows.targets[e];
            if (edge.target == b && std::isfinite(truth[a * n + u]) &&
                truth[a * n + u] + edge.weight == truth[a * n + b]) {
              lowest = std::min(lowest, static_cast<std::uint16_t>(u));
            }
          }
        }
        ASSERT_EQ(paths.before(a, b), lowest) << seed << ": " << a << " to " << b;
      }
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::graph
