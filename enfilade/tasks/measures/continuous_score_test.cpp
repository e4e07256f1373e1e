#include "enfilade/tasks/continuous_score.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "enfilade/core/rng.h"

namespace enfilade::tasks {
namespace EN_UNIT {

// Sums of single-precision lengths of the order of 1.
constexpr double kSingle = 1e-6;

// A walk along x, with the distance that is left to x = goal.
struct Line {
  Line(const std::vector<float>& xs, float goal, std::vector<std::uint8_t> acts)
      : actions(std::move(acts)), collided(actions.size()) {
    for (const float x : xs) {
      positions.push_back({x, 0, 0});
      distances.push_back(std::abs(static_cast<double>(goal - x)));
    }
  }
  ContinuousWalk walk() const { return {positions, actions, distances, collided}; }

  std::vector<std::array<float, 3>> positions;
  std::vector<std::uint8_t> actions;
  std::vector<double> distances;
  std::vector<std::uint8_t> collided;
};

const std::vector<Point3> kReference{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {4, 0, 0}};

TEST(ContinuousScore, OfAWalkThatStopsNearTheGoal) {
  Line line({0, 1, 2, 2}, 4, {1, 1, 0});
  line.collided[1] = 1;
  const ContinuousScore s = score_continuous(line.walk(), kReference);
  EXPECT_EQ(s.distance_to_goal, 2);
  EXPECT_EQ(s.success, 1);
  EXPECT_NEAR(s.path_length, 2, kSingle);
  EXPECT_EQ(s.spl, 1) << "shorter than the shortest way counts as that";
  EXPECT_EQ(s.steps_taken, 3);
  EXPECT_EQ(s.collisions, 1);
  EXPECT_EQ(s.dtw, 2) << "the last of the reference is 2 m from the walk's end";
  EXPECT_DOUBLE_EQ(s.ndtw, std::exp(-2.0 / 12));
  EXPECT_EQ(s.sdtw, s.ndtw);
}

TEST(ContinuousScore, ThereIsNoSuccessWithoutStop) {
  const Line line({0, 1, 2}, 4, {1, 1});
  const ContinuousScore s = score_continuous(line.walk(), kReference);
  EXPECT_EQ(s.success, 0);
  EXPECT_EQ(s.oracle_success, 1);
  const EtpNavScore etpnav = score_as_etpnav(line.walk(), kReference);
  EXPECT_EQ(etpnav.success, 1) << "who copies ETPNav does not ask for stop";
  EXPECT_NEAR(etpnav.path_length, 2, kSingle);
}

TEST(ContinuousScore, AtExactlyThreeMetresTheTwoDiffer) {
  const Line line({0, 1, 1}, 4, {1, 0});
  EXPECT_EQ(score_continuous(line.walk(), kReference).success, 0);
  EXPECT_EQ(score_as_etpnav(line.walk(), kReference).success, 1);
}

TEST(ContinuousScore, BeforeTheFirstAction) {
  const Line line({0, 1}, 4, {1});
  const ContinuousScore s = score_continuous(line.walk(), kReference, 0);
  EXPECT_FALSE(s.collisions.has_value());
  EXPECT_EQ(s.steps_taken, 0);
  EXPECT_EQ(s.distance_to_goal, 4);
  EXPECT_EQ(s.oracle_navigation_error, 4);
}

TEST(ContinuousScore, CollisionsMayBeUnknown) {
  const Line line({0, 1}, 4, {1});
  ContinuousWalk walk = line.walk();
  walk.collided = {};
  EXPECT_FALSE(score_continuous(walk, kReference).collisions.has_value());
  EXPECT_TRUE(std::isnan(score_as_etpnav(walk, kReference).collisions));
  EXPECT_EQ(score_continuous(walk, kReference).steps_taken, 1);
}

TEST(ContinuousScore, ASlowDriftIsSeenLate) {
  Line line({0, 0.00008F, 0.00016F, 0.00016F}, 4, {1, 1, 2});
  line.distances = {4, 3.5, 3.25, 3};  // asked after the second step, as the first is too short
  EXPECT_EQ(score_continuous(line.walk(), kReference, 1).distance_to_goal, 4);
  EXPECT_EQ(score_continuous(line.walk(), kReference, 2).distance_to_goal, 3.25);
  EXPECT_EQ(score_continuous(line.walk(), kReference, 3).distance_to_goal, 3.25);
}

TEST(ContinuousScore, WhatThePublicMeasuresDivideByZeroFor) {
  const Line line({0, 0}, 0, {0});
  EXPECT_TRUE(std::isnan(score_continuous(line.walk(), kReference).spl));
  Line lost({0, 1}, 4, {1});
  lost.distances = {std::numeric_limits<double>::infinity(),
                    std::numeric_limits<double>::infinity()};
  const ContinuousScore s = score_continuous(lost.walk(), kReference);
  EXPECT_EQ(s.success, 0);
  EXPECT_TRUE(std::isinf(s.distance_to_goal));
}

std::vector<Point3> random_points(Rng& rng, std::size_t n) {
  std::vector<Point3> points(n);
  Point3 at{};
  for (Point3& point : points) {
    for (double& c : at) c += rng.uniform() - 0.5;
    point = at;
  }
  return points;
}

// Time warping straight from its definition.
double slow_dtw(std::span<const Point3> a, std::span<const Point3> b, std::size_t i,
                std::size_t j) {
  const double here = std::hypot(a[i][0] - b[j][0], a[i][1] - b[j][1], a[i][2] - b[j][2]);
  if (i == 0 && j == 0) return here;
  double least = std::numeric_limits<double>::infinity();
  if (i > 0) least = std::min(least, slow_dtw(a, b, i - 1, j));
  if (j > 0) least = std::min(least, slow_dtw(a, b, i, j - 1));
  if (i > 0 && j > 0) least = std::min(least, slow_dtw(a, b, i - 1, j - 1));
  return here + least;
}

TEST(FastDtw, ExactIsTheDefinition) {
  Rng rng(7);
  for (int k = 0; k < 50; ++k) {
    const auto a = random_points(rng, 1 + rng.below(6)), b = random_points(rng, 1 + rng.below(6));
    // Rounding of at most 11 sums of the order of 1.
    EXPECT_NEAR(exact_dtw(a, b), slow_dtw(a, b, a.size() - 1, b.size() - 1), 1e-14);
  }
}

TEST(FastDtw, IsExactForShortListsAndNeverLess) {
  Rng rng(8);
  std::size_t larger = 0;
  for (int k = 0; k < 300; ++k) {
    const auto a = random_points(rng, 1 + rng.below(60)), b = random_points(rng, 1 + rng.below(60));
    const double exact = exact_dtw(a, b);
    for (const FastDtw form : {FastDtw::kPlain, FastDtw::kCompiled}) {
      const double fast = fast_dtw(a, b, form);
      EXPECT_GE(fast, exact - 1e-12);  // the same sums in another order
      if (a.size() < 3 || b.size() < 3) {
        EXPECT_NEAR(fast, exact, 1e-12);
      }
      larger += fast > exact + 1e-9 ? 1 : 0;
    }
  }
  EXPECT_GT(larger, 0U) << "it approximates, or this tests nothing";
}

TEST(FastDtw, OfAListAndItselfIsNothing) {
  Rng rng(9);
  for (const std::size_t n : {1U, 2U, 3U, 7U, 64U, 101U}) {
    const auto a = random_points(rng, n);
    EXPECT_EQ(fast_dtw(a, a, FastDtw::kPlain), 0) << n;
    EXPECT_EQ(fast_dtw(a, a, FastDtw::kCompiled), 0) << n;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
