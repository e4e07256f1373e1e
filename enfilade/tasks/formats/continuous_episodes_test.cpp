// VLN-CE's real files: what they hold, how they come from R2R, and how their expert walks.
#include "enfilade/tasks/continuous_episodes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include <ostream>
#include <set>
#include <unordered_map>

#include "enfilade/core/gzip.h"
#include "enfilade/graph/graph_set.h"
#include "enfilade/scan/data_root.h"

namespace enfilade::tasks {
namespace EN_UNIT {

using ::testing::Each;
using ::testing::ElementsAre;
using Json = nlohmann::json;

/// What is known of a split. Without actions for those that have no experts' walks.
struct Split {
  const char* name;
  std::size_t episodes, trajectories, scans;
  std::size_t of_three, of_four;  // trajectories with so many instructions
  std::size_t nodes, tokens;      // of reference paths; that are not padding
  double mean_geodesic, least_geodesic, most_geodesic;
  std::array<std::size_t, 4> actions;  // stop, forward, left, right

  friend std::ostream& operator<<(std::ostream& out, const Split& one) { return out << one.name; }
};
constexpr std::array<Split, 4> kSplits{{
    {"train", 10819, 3603, 61, 3593, 10, 64379, 315962, 9.2745, 3.24, 25.16, {}},
    {"val_seen", 778, 259, 53, 258, 1, 4716, 22999, 9.5805, 4.44, 17.92, {778, 30442, 7586, 6127}},
    {"val_unseen",
     1839,
     613,
     11,
     613,
     0,
     10803,
     53634,
     8.8993,
     3.85,
     21.05,
     {1839, 66768, 16740, 15096}},
    {"test", 3408, 1136, 18, 1136, 0, 0, 98903, 0, 0, 0, {}},
}};

double horizontal(Vec3d a, Vec3d b) { return std::hypot(a.x - b.x, a.y - b.y); }

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

class RealVlnCe : public ::testing::TestWithParam<Split> {
 protected:
  void SetUp() override {
    data_ = scan::DataRoot::from_environment();
    if (!data_) GTEST_SKIP() << "ENFILADE_DATA is not set";
    if (!std::filesystem::exists(file(".json.gz"))) {
      GTEST_SKIP() << "ENFILADE_DATA has no files of VLN-CE: vlnce/*.json.gz";
    }
  }

  std::filesystem::path file(const std::string& end) const {
    return data_->folder() / "vlnce" / (std::string(GetParam().name) + end);
  }
  ContinuousEpisodes episodes() const {
    return load_continuous_episodes(file(".json.gz"), GetParam().name);
  }
  bool has_experts() const { return GetParam().actions[0] > 0; }
  bool hidden() const { return GetParam().nodes == 0; }

  std::optional<scan::DataRoot> data_;
};

TEST_P(RealVlnCe, HasTheKnownCounts) {
  const Split& known = GetParam();
  const ContinuousEpisodes all = episodes();
  std::map<FileId, std::size_t> instructions;
  std::set<std::string_view> scans;
  std::size_t nodes = 0, tokens = 0;
  double sum = 0, least = 100, most = 0;
  for (const ContinuousEpisode& one : all.episodes) {
    ++instructions[one.trajectory_id];
    scans.insert(one.scan());
    ASSERT_EQ(one.instruction.tokens->size(), 200U);
    tokens += static_cast<std::size_t>(
        std::ranges::count_if(*one.instruction.tokens, [](auto token) { return token != 0; }));
    ASSERT_EQ(one.goal_hidden(), hidden());
    if (hidden()) continue;
    ASSERT_EQ(one.goals->size(), 1U);
    EXPECT_EQ(one.goals->at(0).radius, 3.0);
    EXPECT_EQ(one.start, one.reference_path->front());
    EXPECT_EQ(one.goals->at(0).position, one.reference_path->back());
    nodes += one.reference_path->size();
    const double geodesic = *one.info->geodesic_distance;
    EXPECT_GE(geodesic, length(one.goals->at(0).position - one.start) - 1e-4);
    sum += geodesic;
    least = std::min(least, geodesic);
    most = std::max(most, geodesic);
  }
  EXPECT_EQ(all.episodes.size(), known.episodes);
  EXPECT_EQ(instructions.size(), known.trajectories);
  EXPECT_EQ(scans.size(), known.scans);
  EXPECT_EQ(nodes, known.nodes);
  EXPECT_EQ(tokens, known.tokens);
  const auto with = [&instructions](std::size_t count) {
    return static_cast<std::size_t>(std::ranges::count_if(
        instructions, [count](const auto& one) { return one.second == count; }));
  };
  EXPECT_EQ(with(3), known.of_three);
  EXPECT_EQ(with(4), known.of_four);
  EXPECT_EQ(all.vocabulary->words.size(), 2504U);
  EXPECT_EQ(all.vocabulary->size, 2504);
  EXPECT_EQ(all.vocabulary->unknown, 1);
  EXPECT_EQ(all.vocabulary->padding, 0);
  if (hidden()) return;
  EXPECT_NEAR(sum / static_cast<double>(all.episodes.size()), known.mean_geodesic, 5e-5);
  EXPECT_NEAR(least, known.least_geodesic, 6e-3);
  EXPECT_NEAR(most, known.most_geodesic, 6e-3);
}

class RealVlnCeWritten : public RealVlnCe {};

TEST_P(RealVlnCeWritten, HasEqualJsonValues) {
  const TextFile content(file(".json.gz"));
  const ContinuousEpisodes read = parse_continuous_episodes(content.text(), "<text>", "made");
  EXPECT_TRUE(Json::parse(to_json(read)) == Json::parse(content.text()));
  if (!has_experts()) return;
  const TextFile walks(file("_gt.json.gz"));
  EXPECT_TRUE(Json::parse(to_json(parse_expert_walks(walks.text(), "<text>"))) ==
              Json::parse(walks.text()));
}

TEST_P(RealVlnCe, StartsUprightAndTheSameForAllInstructionsOfATrajectory) {
  std::map<FileId, StartRotation> rotations;
  for (const ContinuousEpisode& one : episodes().episodes) {
    EXPECT_EQ(one.rotation.x, 0);
    EXPECT_EQ(one.rotation.z, 0);
    EXPECT_NEAR(std::hypot(one.rotation.y, one.rotation.w), 1, 1e-6);
    EXPECT_EQ(rotations.emplace(one.trajectory_id, one.rotation).first->second, one.rotation);
  }
}

// Each trajectory with its path of R2R.
class RealVlnCeFromR2r : public RealVlnCe {
 protected:
  void SetUp() override {
    RealVlnCe::SetUp();
    if (IsSkipped()) return;
    annotations_ = load_annotations(data_->annotations(GetParam().name), GetParam().name);
    for (const PathAnnotation& path : annotations_.paths) by_id_.emplace(path.path_id, &path);
    graphs_ = graph::GraphSet::open(data_->connectivity());
  }

  const PathAnnotation& path_of(const ContinuousEpisode& one) const {
    return *by_id_.at(std::get<std::int64_t>(one.trajectory_id));
  }

  Annotations annotations_;
  std::unordered_map<std::int64_t, const PathAnnotation*> by_id_;
  std::shared_ptr<const graph::GraphSet> graphs_;
};

TEST_P(RealVlnCeFromR2r, HasR2rsPathsAndInstructionsInTheirOrder) {
  std::int64_t before = -1;
  std::size_t k = 0;
  for (const ContinuousEpisode& one : episodes().episodes) {
    const PathAnnotation& path = path_of(one);  // throws for a trajectory that R2R does not have
    k = before == path.path_id ? k + 1 : 0;
    before = path.path_id;
    ASSERT_LT(k, path.instructions.size());
    EXPECT_EQ(one.instruction.text, path.instructions[k]);
    EXPECT_EQ(one.scan(), path.scan);
    EXPECT_EQ(one.reference_path.value_or(std::vector<Vec3d>(1)).size(), path.path.size());
  }
}

TEST_P(RealVlnCeFromR2r, HasOneNodeAViewpointAndMostStandUnderIt) {
  std::map<std::pair<std::string, std::string>, Vec3d> nodes;
  std::size_t all = 0, near = 0;
  double worst = 0;
  for (const ContinuousEpisode& one : episodes().episodes) {
    const PathAnnotation& path = path_of(one);
    const std::vector<Vec3d> points = one.reference_path.value_or(std::vector{one.start});
    for (std::size_t k = 0; k < points.size(); ++k) {
      const graph::Location at = graphs_->locate(path.scan, path.path[k]);
      const graph::NavGraph& graph = graphs_->graph(at.scan);
      const Vec3d viewpoint = to_double(graph.position(at.viewpoint));
      const auto [first, fresh] = nodes.emplace(std::pair(path.scan, path.path[k]), points[k]);
      EXPECT_EQ(first->second, points[k]);
      const double off = horizontal(points[k], viewpoint);
      ++all;
      near += off < 1e-3 ? 1 : 0;
      worst = std::max(worst, off);
    }
  }
  const double share = static_cast<double>(near) / static_cast<double>(all);
  RecordProperty("share_within_1_mm", std::to_string(share));
  const std::map<std::string, double> known{
      {"train", 0.986}, {"val_seen", 0.989}, {"val_unseen", 0.987}};
  if (!hidden()) {
    EXPECT_NEAR(share, known.at(GetParam().name), 5e-4);
  }
  EXPECT_LT(worst, 1.6);
}

TEST(RealVlnCeNodes, StandWhereTheFloorIsKnownToBe) {
  const auto data = scan::DataRoot::from_environment();
  if (!data || !std::filesystem::exists(data->folder() / "vlnce")) {
    GTEST_SKIP() << "ENFILADE_DATA is not set, or has no files of VLN-CE: vlnce/*.json.gz";
  }
  const auto graphs = graph::GraphSet::open(data->connectivity());
  std::map<graph::Location, Vec3d, decltype([](graph::Location a, graph::Location b) {
             return std::pair(a.scan.at(), a.viewpoint.at()) <
                    std::pair(b.scan.at(), b.viewpoint.at());
           })>
      nodes;
  for (const Split& split : kSplits) {
    std::unordered_map<std::int64_t, PathAnnotation> paths;
    for (auto& path : load_annotations(data->annotations(split.name), split.name).paths) {
      paths.emplace(path.path_id, std::move(path));
    }
    const auto file = data->folder() / "vlnce" / (std::string(split.name) + ".json.gz");
    for (const auto& one : load_continuous_episodes(file, split.name).episodes) {
      const PathAnnotation& path = paths.at(std::get<std::int64_t>(one.trajectory_id));
      const std::vector<Vec3d> points = one.reference_path.value_or(std::vector{one.start});
      for (std::size_t k = 0; k < points.size(); ++k) {
        const auto at = graphs->locate(path.scan, path.path[k]);
        EXPECT_EQ(nodes.emplace(at, points[k]).first->second, points[k]);
      }
    }
  }
  EXPECT_EQ(nodes.size(), 6643U);
  double worst = 0;
  std::vector<double> below, above_floor;
  for (const auto& [at, node] : nodes) {
    const graph::NavGraph& graph = graphs->graph(at.scan);
    const Vec3d viewpoint = to_double(graph.position(at.viewpoint));
    worst = std::max(worst, horizontal(node, viewpoint));
    below.push_back(viewpoint.z - node.z);
    above_floor.push_back(node.z - (viewpoint.z - graph.height(at.viewpoint)));
  }
  EXPECT_NEAR(worst, 1.59, 5e-3);
  EXPECT_NEAR(median(below), 1.410, 5e-4);
  EXPECT_NEAR(median(above_floor), 0.107, 5e-4);
}

// How an expert's actions and locations go together.
class RealExperts : public RealVlnCe {
 protected:
  void SetUp() override {
    RealVlnCe::SetUp();
    if (!IsSkipped() && !has_experts()) GTEST_SKIP() << "the split has no experts' walks";
  }
};

constexpr double kStep = 0.25;
constexpr double kTurn = 15 * kPi / 180;

// The heading after an action, clockwise.
double turned(double heading, std::uint8_t action) {
  if (action == 2) return heading - kTurn;
  return action == 3 ? heading + kTurn : heading;
}

Vec3d stepped(Vec3d from, double heading) {
  return {from.x + kStep * std::sin(heading), from.y + kStep * std::cos(heading), from.z};
}

TEST_P(RealExperts, HaveTheKnownActions) {
  const ExpertWalks walks = load_expert_walks(file("_gt.json.gz"));
  std::array<std::size_t, 4> actions{};
  for (const ContinuousEpisode& one : episodes().episodes) {
    const ExpertWalk& walk = walks.at(text_of(one.id));
    EXPECT_EQ(walk.locations.front(), one.start);
    EXPECT_EQ(walk.locations.size(), static_cast<std::size_t>(walk.forward_steps) + 1);
    EXPECT_EQ(std::ranges::count(walk.actions, 1), walk.forward_steps);
    EXPECT_EQ(std::ranges::count(walk.actions, 0), 1);
    EXPECT_EQ(walk.actions.back(), 0);
    for (std::size_t k = 0; k < walk.actions.size(); ++k) {
      ++actions[walk.actions[k]];
      if (k == 0) continue;
      const std::set<int> both{walk.actions[k - 1], walk.actions[k]};
      EXPECT_NE(both, (std::set<int>{2, 3}));  // left beside right
    }
  }
  EXPECT_EQ(walks.size(), GetParam().episodes);
  EXPECT_EQ(actions, GetParam().actions);
}

TEST_P(RealExperts, WalkByDeadReckoningUntilTheySlide) {
  const ExpertWalks walks = load_expert_walks(file("_gt.json.gz"));
  std::size_t steps = 0, straight = 0, before_slide = 0;
  double drift = 0;
  for (const ContinuousEpisode& one : episodes().episodes) {
    const ExpertWalk& walk = walks.at(text_of(one.id));
    double heading = one.start_heading().value;
    Vec3d reckoned = one.start;
    bool slid = false;
    std::size_t at = 0;
    for (const std::uint8_t action : walk.actions) {
      heading = turned(heading, action);
      if (action != 1) continue;
      const Vec3d here = walk.locations[at], next = walk.locations[at + 1];
      const bool as_said = horizontal(next, stepped(here, heading)) < 1e-3;
      slid = slid || !as_said;
      reckoned = stepped(reckoned, heading);
      ++at, ++steps;
      straight += as_said ? 1 : 0;
      before_slide += slid ? 0 : 1;
      if (!slid) drift = std::max(drift, horizontal(next, reckoned));
    }
  }
  const auto share = [steps](std::size_t count) {
    return static_cast<double>(count) / static_cast<double>(steps);
  };
  EXPECT_NEAR(share(straight), 0.988, 5e-4);  // single steps from where the expert stood
  EXPECT_NEAR(share(before_slide), GetParam().episodes == 778 ? 0.804 : 0.817, 5e-4);
  EXPECT_LT(drift, 1e-3);  // of whole walks, until the first slide
}

// What an expert would do that takes the straight line for the shortest path.
std::uint8_t straight_line_action(Vec3d here, double heading, Vec3d goal) {
  const double off =
      wrap_difference(Radians(std::atan2(goal.x - here.x, goal.y - here.y) - heading)).value;
  if (std::abs(off) <= kTurn + 1e-6) return 1;
  // Left is tried first, so that a goal exactly behind is turned to on the left.
  return std::abs(wrap_difference(Radians(off + kTurn)).value) < std::abs(off) ? 2 : 3;
}

TEST_P(RealExperts, VisitTheNodesInOrderAndMostlyGoStraightToThem) {
  const ExpertWalks walks = load_expert_walks(file("_gt.json.gz"));
  constexpr double kReached = 0.5;
  std::size_t all = 0, as_expected = 0, stops = 0, early = 0, unvisited = 0;
  for (const ContinuousEpisode& one : episodes().episodes) {
    const ExpertWalk& walk = walks.at(text_of(one.id));
    const std::vector<Vec3d>& nodes = *one.reference_path;
    double heading = one.start_heading().value;
    std::size_t at = 0, node = 0;
    for (const std::uint8_t action : walk.actions) {
      const Vec3d here = walk.locations[at];
      while (node < nodes.size() && length(nodes[node] - here) < kReached) ++node;
      const std::uint8_t expected =
          node == nodes.size() ? 0 : straight_line_action(here, heading, nodes[node]);
      ++all;
      as_expected += expected == action ? 1 : 0;
      stops += expected == 0 && action == 0 ? 1 : 0;
      early += expected == 0 && action != 0 ? 1 : 0;
      heading = turned(heading, action);
      at += action == 1 ? 1 : 0;
    }
    unvisited += nodes.size() - node;
  }
  EXPECT_EQ(unvisited, 0U);
  EXPECT_EQ(stops, GetParam().episodes);
  const bool seen = GetParam().episodes == 778;
  EXPECT_EQ(early, seen ? 12U : 6U);
  EXPECT_NEAR(static_cast<double>(as_expected) / static_cast<double>(all), seen ? 0.9032 : 0.9076,
              1e-4);
}

std::string name_of(const ::testing::TestParamInfo<Split>& info) { return info.param.name; }

INSTANTIATE_TEST_SUITE_P(Splits, RealVlnCe, ::testing::ValuesIn(kSplits), name_of);
// Without train, which has the same form, and takes as long as the others three times.
INSTANTIATE_TEST_SUITE_P(Splits, RealVlnCeWritten,
                         ::testing::Values(kSplits[1], kSplits[2], kSplits[3]), name_of);
INSTANTIATE_TEST_SUITE_P(Splits, RealVlnCeFromR2r, ::testing::ValuesIn(kSplits), name_of);
INSTANTIATE_TEST_SUITE_P(Splits, RealExperts, ::testing::Values(kSplits[1], kSplits[2]), name_of);

}  // namespace EN_UNIT
}  // namespace enfilade::tasks
