#include "enfilade/tasks/metrics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <vector>

#include "enfilade/core/rng.h"
#include "tests/support/graphs.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using graph::NavGraph;
using Walk = std::vector<ViewpointIndex>;

// Rounding of a few sums and one exp; values are of the order of 10.
constexpr double kRounding = 1e-14;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Walk walk(std::initializer_list<std::size_t> viewpoints) {
  Walk result;
  for (const std::size_t v : viewpoints) result.emplace_back(v);
  return result;
}

// v0 .. v5 in a row, 2 m apart, and v6 - v7 out of reach of them.
NavGraph row() {
  return NavGraph(graph::testing::connectivity(
      "row",
      {{0, 0, 0}, {2, 0, 0}, {4, 0, 0}, {6, 0, 0}, {8, 0, 0}, {10, 0, 0}, {0, 9, 0}, {2, 9, 0}},
      {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}, {6, 7}}));
}

TEST(Metrics, OfThePerfectTrajectory) {
  const Walk path = walk({0, 1, 2, 3});
  const EpisodeMetrics m = compute_metrics(row(), path, path);
  EXPECT_EQ(m.steps, 3);
  EXPECT_EQ(m.moves, 3);
  EXPECT_EQ(m.trajectory_length, 6);
  EXPECT_EQ(m.reference_length, 6);
  EXPECT_EQ(m.shortest, 6);
  EXPECT_EQ(m.nav_error, 0);
  EXPECT_EQ(m.oracle_error, 0);
  EXPECT_EQ(m.dtw, 0);
  EXPECT_EQ(m.dtw_collapsed, 0);
  for (const double share : {m.success, m.oracle_success, m.spl, m.spl_refpath, m.ndtw, m.sdtw,
                             m.ndtw_collapsed, m.sdtw_collapsed, m.coverage, m.cls}) {
    EXPECT_EQ(share, 1);
  }
}

TEST(Metrics, OfATrajectoryThatStopsEarly) {
  const EpisodeMetrics m = compute_metrics(row(), walk({0, 1, 2}), walk({0, 1, 2, 3}));
  EXPECT_EQ(m.trajectory_length, 4);
  EXPECT_EQ(m.nav_error, 2);
  EXPECT_EQ(m.success, 1);
  EXPECT_EQ(m.spl, 1) << "6 / max(4, 6)";
  EXPECT_EQ(m.dtw, 2) << "v3 is aligned with v2";
  EXPECT_NEAR(m.ndtw, std::exp(-2.0 / (4 * 3)), kRounding);
  const double coverage = (3 + std::exp(-2.0 / 3)) / 4;
  EXPECT_NEAR(m.coverage, coverage, kRounding);
  const double expected = coverage * 6;  // 5.27 m, more than the 4 m walked
  EXPECT_NEAR(m.cls, coverage * expected / (expected + expected - 4), kRounding);
}

TEST(Metrics, OfATrajectoryThatGoesTooFarAndTurns) {
  const EpisodeMetrics m = compute_metrics(row(), walk({0, 1, 2, 3, 4, 4, 5}), walk({0, 1, 2, 3}));
  EXPECT_EQ(m.steps, 6);
  EXPECT_EQ(m.moves, 5);
  EXPECT_EQ(m.trajectory_length, 10);
  EXPECT_EQ(m.nav_error, 4);
  EXPECT_EQ(m.oracle_error, 0);
  EXPECT_EQ(m.success, 0);
  EXPECT_EQ(m.oracle_success, 1);
  EXPECT_EQ(m.spl, 0);
  EXPECT_EQ(m.dtw, 8) << "v4, v4 and v5 are aligned with v3: 2 + 2 + 4";
  EXPECT_EQ(m.dtw_collapsed, 6) << "2 + 4";
  EXPECT_EQ(m.sdtw, 0);
  EXPECT_EQ(m.coverage, 1);
  EXPECT_NEAR(m.cls, 6.0 / (6 + 4), kRounding);
}

TEST(Metrics, DetoursCostSpl) {
  const EpisodeMetrics m = compute_metrics(row(), walk({1, 0, 1, 2, 3}), walk({1, 2, 1, 2, 3}));
  EXPECT_EQ(m.spl, 0.5) << "4 / 8";
  EXPECT_EQ(m.spl_refpath, 1) << "the reference takes a detour of 8 m too";
}

TEST(Metrics, SuccessIsStrictlyNearer) {
  const NavGraph graph(graph::testing::connectivity("s", {{0, 0, 0}, {3, 0, 0}}, {{0, 1}}));
  EXPECT_EQ(compute_metrics(graph, walk({0}), walk({0, 1})).success, 0);
  EXPECT_EQ(compute_metrics(graph, walk({0}), walk({0, 1}), {3.001}).success, 1);
}

TEST(Metrics, NothingToWalk) {
  const EpisodeMetrics stayed = compute_metrics(row(), walk({2}), walk({2}));
  EXPECT_EQ(stayed.spl, 1);
  EXPECT_EQ(stayed.spl_refpath, 1);
  EXPECT_EQ(stayed.cls, 1);
  EXPECT_EQ(stayed.steps, 0);
  const EpisodeMetrics walked = compute_metrics(row(), walk({2, 3, 2}), walk({2}));
  EXPECT_EQ(walked.spl, 0) << "0 / 4";
  EXPECT_EQ(walked.cls, 0);
}

// What a field may be where distances have no end.
void expect_sane(const EpisodeMetrics& m) {
  for (const MetricField& field : kMetricFields) {
    EXPECT_GE(m.*field.field, 0) << field.name;  // false for NaN
  }
  for (const double share : {m.success, m.oracle_success, m.spl, m.spl_refpath, m.ndtw, m.sdtw,
                             m.ndtw_collapsed, m.sdtw_collapsed, m.coverage, m.cls}) {
    EXPECT_LE(share, 1);
  }
}

TEST(Metrics, OutOfReach) {
  const EpisodeMetrics m = compute_metrics(row(), walk({6, 7, 7}), walk({0, 1, 2}));
  expect_sane(m);
  EXPECT_EQ(m.nav_error, kInfinity);
  EXPECT_EQ(m.oracle_error, kInfinity);
  EXPECT_EQ(m.ndtw, 0);
  EXPECT_EQ(m.coverage, 0);
  EXPECT_EQ(m.cls, 0);
  const EpisodeMetrics jump = compute_metrics(row(), walk({0, 7, 2}), walk({0, 1, 2}));
  expect_sane(jump);
  EXPECT_EQ(jump.success, 1);
  EXPECT_EQ(jump.spl, 0) << "its length has no end";
  EXPECT_EQ(jump.cls, 0);
  const EpisodeMetrics broken = compute_metrics(row(), walk({0, 1}), walk({0, 6, 1}));
  expect_sane(broken);
  EXPECT_EQ(broken.reference_length, kInfinity);
  EXPECT_EQ(broken.spl, 1);
  EXPECT_EQ(broken.spl_refpath, 0);
  expect_sane(compute_metrics(row(), walk({0}), walk({0, 6})));
}

TEST(Metrics, FieldsNameEachNumberOnce) {
  std::set<std::string> names;
  for (const MetricField& field : kMetricFields) names.insert(field.name);
  EXPECT_EQ(names.size(), kMetricFields.size());
  EXPECT_EQ(names.size(), sizeof(EpisodeMetrics) / sizeof(double));
  EpisodeMetrics m;
  for (const MetricField& field : kMetricFields) m.*field.field += 1;
  for (const MetricField& field : kMetricFields) EXPECT_EQ(m.*field.field, 1) << field.name;
}

// The slow twin: each definition as it is written, with the whole table of the time warping.
double warp(const NavGraph& graph, const Walk& p, const Walk& r) {
  std::vector<std::vector<double>> c(p.size() + 1, std::vector<double>(r.size() + 1, kInfinity));
  c[0][0] = 0;
  for (std::size_t i = 1; i <= p.size(); ++i) {
    for (std::size_t j = 1; j <= r.size(); ++j) {
      c[i][j] = graph.distance(p[i - 1], r[j - 1]) +
                std::min({c[i - 1][j - 1], c[i - 1][j], c[i][j - 1]});
    }
  }
  return c.back().back();
}

double length_of(const NavGraph& graph, const Walk& p) {
  double sum = 0;
  for (std::size_t i = 0; i + 1 < p.size(); ++i) sum += graph.distance(p[i], p[i + 1]);
  return sum;
}

EpisodeMetrics twin(const NavGraph& graph, const Walk& p, const Walk& r, double t) {
  EpisodeMetrics m;
  m.steps = double(p.size()) - 1;
  Walk collapsed = p;
  collapsed.erase(std::unique(collapsed.begin(), collapsed.end()), collapsed.end());
  m.moves = double(collapsed.size()) - 1;
  m.trajectory_length = length_of(graph, p);
  m.reference_length = length_of(graph, r);
  m.shortest = graph.distance(r.front(), r.back());
  m.nav_error = graph.distance(p.back(), r.back());
  m.oracle_error = kInfinity;
  for (const auto v : p) m.oracle_error = std::min(m.oracle_error, graph.distance(v, r.back()));
  m.success = m.nav_error < t ? 1 : 0;
  m.oracle_success = m.oracle_error < t ? 1 : 0;
  const auto spl = [&](double length) {
    const double most = std::max(length, m.trajectory_length);
    return most > 0 ? m.success * length / most : m.success;
  };
  m.spl = spl(m.shortest);
  m.spl_refpath = spl(m.reference_length);
  m.dtw = warp(graph, p, r);
  m.dtw_collapsed = warp(graph, collapsed, r);
  m.ndtw = std::exp(-m.dtw / (double(r.size()) * t));
  m.ndtw_collapsed = std::exp(-m.dtw_collapsed / (double(r.size()) * t));
  m.sdtw = m.success * m.ndtw;
  m.sdtw_collapsed = m.success * m.ndtw_collapsed;
  for (const auto v : r) {
    double nearest = kInfinity;
    for (const auto u : p) nearest = std::min(nearest, graph.distance(u, v));
    m.coverage += std::exp(-nearest / t) / double(r.size());
  }
  const double expected = m.coverage * m.reference_length;
  const double off = std::abs(expected - m.trajectory_length);
  m.cls = m.coverage * (expected + off > 0 ? expected / (expected + off) : 1);
  return m;
}

Walk random_walk(const NavGraph& graph, std::size_t start, std::size_t steps, Rng& rng) {
  Walk path{ViewpointIndex(start)};
  for (std::size_t i = 0; i < steps; ++i) {
    const auto edges = graph.edges(path.back());
    const std::size_t k = rng.below(edges.size() + 1);  // one more: a turn on the spot
    path.push_back(k < edges.size() ? edges[k].target : path.back());
  }
  return path;
}

TEST(Metrics, AgreeWithTheirDefinitionsOnRandomWalks) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Rng rng(seed);
    std::vector<Vec3d> points;
    std::vector<std::pair<int, int>> edges;
    for (int i = 0; i < 12; ++i) {
      points.push_back({6 * rng.uniform(), 6 * rng.uniform(), rng.uniform()});
      if (i > 0) edges.emplace_back(int(rng.below(std::uint64_t(i))), i);
    }
    edges.emplace_back(0, 11);
    const NavGraph graph(graph::testing::connectivity("s", points, edges));
    const Walk r = random_walk(graph, rng.below(12), rng.below(8), rng);
    const Walk p = random_walk(graph, r[0].at(), rng.below(15), rng);
    const double t = 1 + 3 * rng.uniform();
    const EpisodeMetrics fast = compute_metrics(graph, p, r, {t});
    const EpisodeMetrics slow = twin(graph, p, r, t);
    expect_sane(fast);
    for (const MetricField& field : kMetricFields) {
      // Sums of up to 30 terms of the order of 10, in another order.
      EXPECT_NEAR(fast.*field.field, slow.*field.field, 1e-12) << field.name << ", seed " << seed;
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
