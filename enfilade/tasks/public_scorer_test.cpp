#include "enfilade/tasks/public_scorer.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "tests/support/graphs.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using Walk = std::vector<ViewpointIndex>;
using Values = std::map<std::string, double>;

Walk walk(std::initializer_list<std::size_t> viewpoints) {
  Walk result;
  for (const std::size_t v : viewpoints) result.emplace_back(v);
  return result;
}

// v0 .. v5 in a row, 1.5 m apart: two steps are exactly 3 m.
const graph::NavGraph& row() {
  static const graph::NavGraph kRow(graph::testing::connectivity(
      "row", {{0, 0, 0}, {1.5, 0, 0}, {3, 0, 0}, {4.5, 0, 0}, {6, 0, 0}, {7.5, 0, 0}},
      {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}}));
  return kRow;
}

Trajectory along(std::initializer_list<std::size_t> viewpoints) {
  Trajectory trajectory;
  for (const ViewpointIndex v : walk(viewpoints)) {
    trajectory.points.push_back({v, Radians(0), Radians(0)});
  }
  return trajectory;
}

ReferencePath reference(const Walk& path, Goal goal = NearEnd()) {
  ReferencePath result;
  result.viewpoints = path;
  result.goal = std::move(goal);
  return result;
}

Values score(Task task, const char* name, const ReferencePath& path, const Trajectory& trajectory) {
  const PublicScorer& scorer = public_scorer(task, name);
  std::vector<double> values(scorer.metrics.size());
  scorer.score(row(), path, trajectory, values);
  Values named;
  for (std::size_t k = 0; k < values.size(); ++k) named[scorer.metrics[k].name] = values[k];
  return named;
}

TEST(PublicScorers, EachHasItsNameAndMetricsOnce) {
  std::set<std::pair<Task, std::string_view>> scorers;
  for (const PublicScorer& one : public_scorers()) {
    EXPECT_TRUE(scorers.emplace(one.task, one.name).second) << one.name;
    std::set<std::string> names;
    for (const ScorerMetric& metric : one.metrics) {
      EXPECT_TRUE(names.insert(metric.name).second) << one.name << " " << metric.name;
    }
    EXPECT_FALSE(one.source.empty());
    EXPECT_EQ(&public_scorer(one.task, one.name), &one);
  }
  EXPECT_EQ(public_scorers(Task::kReverie).size(), 3U);
  EXPECT_EQ(public_scorers(Task::kR2rBack).size(), 1U);
  EXPECT_THAT([] { public_scorer(Task::kSoon, "hamt"); },
              ThrowsMessage<LookupError>(HasSubstr("duet, official")));
}

// The agent ends 3 m before the goal: "nearer than 3 m" is not reached, "at most 3 m" is.
TEST(PublicScorers, DifferAtExactlyThreeMetres) {
  const auto path = reference(walk({0, 1, 2, 3, 4}));
  const Trajectory early = along({0, 1, 2});
  EXPECT_EQ(score(Task::kR4r, "hamt", path, early)["success"], 0);
  EXPECT_EQ(score(Task::kR4r, "valan", path, early)["sr"], 0);
  const Values authors = score(Task::kR4r, "r4r_public", path, early);
  EXPECT_GT(authors.at("sdtw"), 0);
  EXPECT_EQ(authors.at("sdtw"), authors.at("ndtw"));
}

// The reference goes to v4 and back to v2: 9 m, where 3 m are the shortest way from start to end.
TEST(PublicScorers, DifferInTheLengthOfSpl) {
  const auto path = reference(walk({0, 1, 2, 3, 4, 3, 2}));
  const Trajectory perfect = along({0, 1, 2, 3, 4, 3, 2});
  EXPECT_DOUBLE_EQ(score(Task::kR4r, "duet", path, perfect)["spl"], 1);
  EXPECT_DOUBLE_EQ(score(Task::kR4r, "valan", path, perfect)["spl"], 1.0 / 3);
}

TEST(PublicScorers, WhoStaysAtAReferenceOfOneViewpoint) {
  const auto path = reference(walk({2}));
  const Trajectory stays = along({2});
  EXPECT_TRUE(std::isnan(score(Task::kR4r, "hamt", path, stays)["CLS"]));
  EXPECT_EQ(score(Task::kR4r, "hamt", path, stays)["spl"], 0) << "0 / 0.01";
  EXPECT_EQ(score(Task::kR4r, "valan", path, stays)["cls"], 1);
  EXPECT_TRUE(std::isnan(score(Task::kR4r, "valan", path, stays)["dtw_over_length"]));
}

TEST(PublicScorers, OfR4rInsistOnEdges) {
  const auto path = reference(walk({0, 1, 2}));
  EXPECT_EQ(score(Task::kR4r, "r4r_public", path, along({0, 1, 2}))["cls"], 1);
  EXPECT_TRUE(std::isnan(score(Task::kR4r, "r4r_public", path, along({0, 2}))["cls"]));
  EXPECT_TRUE(std::isnan(score(Task::kR4r, "r4r_public", path, along({0, 1, 1, 2}))["cls"]));
}

TEST(PublicScorers, OfR2rBackWantTheTurningPointSaid) {
  const auto path = reference(walk({0, 1, 2, 3, 2, 1, 0}), TurningPoint{ViewpointIndex(3)});
  Trajectory trajectory = along({0, 1, 2, 3, 2, 1, 0});
  EXPECT_EQ(score(Task::kR2rBack, "hamt", path, trajectory)["success"], 0) << "not said";
  trajectory.turning_point = ViewpointIndex(5);
  EXPECT_EQ(score(Task::kR2rBack, "hamt", path, trajectory)["success"], 1) << "3 m off";
  trajectory.turning_point = ViewpointIndex(0);
  EXPECT_EQ(score(Task::kR2rBack, "hamt", path, trajectory)["success"], 0) << "4.5 m off";
}

TEST(PublicScorers, OfReverieAskWhoSeesTheObjectAndHowItIsNamed) {
  const auto path =
      reference(walk({0, 1, 2, 3}), SeenObject{66, {ViewpointIndex(1), ViewpointIndex(5)}});
  Trajectory trajectory = along({0, 1, 2, 3});  // through a viewpoint that sees it, to one that not
  trajectory.object = "66";
  const Values official = score(Task::kReverie, "official", path, trajectory);
  EXPECT_EQ(official.at("success_rate"), 0);
  EXPECT_EQ(official.at("oracle success_rate"), 1);
  EXPECT_EQ(official.at("rgs"), 1) << "navigation is not asked";
  EXPECT_DOUBLE_EQ(official.at("rgspl"), 1);
  for (const char* wrong : {"", "066", "66 ", "66.0", "67"}) {
    trajectory.object = wrong;
    EXPECT_EQ(score(Task::kReverie, "duet", path, trajectory)["rgs"], 0) << wrong;
  }
  EXPECT_EQ(score(Task::kReverie, "hamt", path, along({0, 1}))["success"], 1);
}

TEST(PublicScorers, OfCvdnMeasureProgressToARegion) {
  const auto path =
      reference(walk({0, 1, 2}), Region{walk({4, 5}), walk({0, 1, 2, 3, 4}), walk({0, 1, 2})});
  const Trajectory trajectory = along({0, 1, 2, 3});
  const Values planner = score(Task::kCvdn, "official planner_path", path, trajectory);
  EXPECT_DOUBLE_EQ(planner.at("dist_to_end_reduction"), 6 - 1.5);
  EXPECT_DOUBLE_EQ(planner.at("nav_error"), 1.5);
  EXPECT_EQ(planner.at("success_rate"), 1);
  // The player walked through the planner's end, and is trusted.
  const Values trusted = score(Task::kCvdn, "official trusted_path", path, trajectory);
  EXPECT_EQ(trusted, score(Task::kCvdn, "official player_path", path, trajectory));
  const Values hamt = score(Task::kCvdn, "hamt", path, trajectory);
  EXPECT_EQ(hamt.at("success"), 0) << "1.5 m from the region";
  EXPECT_DOUBLE_EQ(hamt.at("gp"), 4.5);
  EXPECT_DOUBLE_EQ(score(Task::kCvdn, "valan", path, along({0}))["gp"], 0);
}

Box box(std::size_t viewpoint, double heading, double half) {
  const auto at = [heading](double dh, double de) {
    return Direction{Radians(heading + dh), Radians(de)};
  };
  return {ViewpointIndex(viewpoint),
          at(0, 0),
          {at(-half, half), at(half, half), at(half, -half), at(-half, -half)}};
}

constexpr double kTurn = 6.283185307179586;

TEST(PublicScorers, OfSoonMoveTheGoalToTheBoxThatWasReached) {
  const auto path = reference(walk({0, 1, 2, 3}), Boxes{{box(5, 1, 0.2), box(5, 3, 0.2)}, {}});
  Trajectory trajectory = along({0, 1, 2, 3, 4, 5});
  trajectory.point = SpherePoint{3 / kTurn, 0.5};
  const Values duet = score(Task::kSoon, "duet", path, trajectory);
  EXPECT_EQ(duet.at("nav_error"), 0);
  EXPECT_DOUBLE_EQ(duet.at("oracle_error"), 3) << "the node nearest to the path's end";
  EXPECT_EQ(duet.at("det_success"), 1) << "DUET keeps a viewpoint's last box";
  EXPECT_DOUBLE_EQ(duet.at("goal_progress"), 7.5);
  const Values official = score(Task::kSoon, "official", path, trajectory);
  EXPECT_EQ(official.at("det_success_rate"), 0) << "the released one looks at the first";
  EXPECT_NEAR(official.at("heading_errors"), 2 / kTurn, 1e-15);  // rounding of two quotients
  EXPECT_TRUE(std::isnan(official.at("point_det_errors")));
}

TEST(PublicScorers, OfSoonTakeABoxWithoutItsEdges) {
  const auto path = reference(walk({0}), Boxes{{box(0, 1, 0.25)}, {}});
  const auto detected = [&path](double heading, double elevation) {
    Trajectory trajectory = along({0});
    trajectory.point = SpherePoint{heading / kTurn, elevation / kTurn + 0.5};
    return score(Task::kSoon, "duet", path, trajectory).at("det_success") == 1;
  };
  EXPECT_TRUE(detected(1, 0));
  EXPECT_TRUE(detected(1.24, 0.24));
  EXPECT_FALSE(detected(1.25, 0)) << "on the edge";
  EXPECT_FALSE(detected(0.75, 0.1));
  EXPECT_FALSE(detected(1.26, 0));
  EXPECT_FALSE(detected(1, -0.26));
}

TEST(PublicScorers, TakeMeansByTheirRules) {
  const PublicScorer& soon = public_scorer(Task::kSoon, "official");
  const std::size_t width = soon.metrics.size();
  std::vector<double> values(2 * width, 1);
  const auto at = [&soon](std::string_view name) {
    std::size_t k = 0;
    while (soon.metrics[k].name != name) ++k;
    return k;
  };
  values[at("heading_errors")] = std::numeric_limits<double>::quiet_NaN();
  values[width + at("heading_errors")] = 0.25;
  const auto means = summarise(soon, values);
  EXPECT_EQ(means[at("heading_errors")], 0.25);
  EXPECT_EQ(means[at("nav_error")], 1);
  EXPECT_EQ(means[at("oracle_rate")], 2 / (2 + 1e-9));
  const PublicScorer& duet = public_scorer(Task::kReverie, "duet");
  EXPECT_EQ(summarise(duet, std::vector<double>(duet.metrics.size(), 1)).back(), 100);
  EXPECT_TRUE(std::isnan(summarise(duet, {})[0]));
}

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
