#include "enfilade/neural/seq2seq/evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <cmath>
#include <numeric>

#include "enfilade/core/errors.h"
#include "enfilade/scan/data_root.h"
#include "enfilade/tasks/score_table.h"
#include "tests/support/graphs.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::neural::seq2seq {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr auto kLeft = static_cast<std::int32_t>(SixAction::kLeft);
constexpr auto kRight = static_cast<std::int32_t>(SixAction::kRight);
constexpr auto kUp = static_cast<std::int32_t>(SixAction::kUp);
constexpr auto kDown = static_cast<std::int32_t>(SixAction::kDown);
constexpr auto kForward = static_cast<std::int32_t>(SixAction::kForward);
constexpr auto kEnd = static_cast<std::int32_t>(SixAction::kStop);

using Labels = std::vector<std::int32_t>;

struct PathEnds {
  std::size_t start, goal;
  double heading;  // degrees
};

tasks::EpisodeSet episodes_on(const scan::Connectivity& connectivity,
                              const std::vector<PathEnds>& ends) {
  std::vector<graph::NavGraph> graphs;
  graphs.emplace_back(connectivity);
  tasks::EpisodeSet set{"made", graph::GraphSet::of(std::move(graphs)), {}, {}};
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const auto path = set.graphs->graph(ScanIndex(0))
                          .path(ViewpointIndex(ends[i].start), ViewpointIndex(ends[i].goal));
    set.paths.push_back(
        {static_cast<std::int64_t>(i), ScanIndex(0), degrees(ends[i].heading), path.value()});
    set.episodes.push_back({tasks::instruction_id(static_cast<std::int64_t>(i), 0), i, 0, "walk"});
  }
  return set;
}

// An environment over all episodes of a set at once, and what it shows.
class Walk {
 public:
  Walk(const tasks::EpisodeSet& set, models::AfterEnd after_end = models::AfterEnd::kWalksOn,
       models::ForwardTo forward = models::ForwardTo::kNearest)
      : environment_(set, nullptr, {set.episodes.size(), 20, after_end, forward}) {
    std::vector<std::size_t> all(set.episodes.size());
    std::iota(all.begin(), all.end(), std::size_t{0});
    environment_.start(all);
  }

  Labels labels() {
    open_.resize(environment_.size());
    Labels labels(environment_.size());
    environment_.observe({{}, open_, labels});
    return labels;
  }
  std::vector<std::uint8_t> open() {
    labels();
    return open_;
  }
  bool step(const Labels& actions) { return environment_.step(actions); }
  R2rEnvironment& environment() { return environment_; }
  std::vector<std::size_t> places(std::size_t agent) {
    std::vector<std::size_t> places;
    for (const auto& p : environment_.trajectories()[agent].points)
      places.push_back(p.viewpoint.at());
    return places;
  }
  double heading(std::size_t agent) {
    return to_degrees(environment_.trajectories()[agent].points.back().heading);
  }
  double elevation(std::size_t agent) {
    return to_degrees(environment_.trajectories()[agent].points.back().elevation);
  }

 private:
  R2rEnvironment environment_;
  std::vector<std::uint8_t> open_;
};

TEST(R2rEnvironment, SixActionsDoWhatTheySay) {
  // Corner 0 of the square, looking north at corner 3.
  const tasks::EpisodeSet set = episodes_on(
      graph::testing::square(), {{0, 3, 0}, {0, 3, 0}, {0, 3, 0}, {0, 3, 0}, {0, 3, 0}, {0, 3, 0}});
  Walk walk(set);
  EXPECT_TRUE(walk.step({kLeft, kRight, kUp, kDown, kForward, kEnd}));
  EXPECT_NEAR(walk.heading(0), 330, 1e-9);
  EXPECT_NEAR(walk.heading(1), 30, 1e-9);
  EXPECT_NEAR(walk.elevation(2), 30, 1e-9);
  EXPECT_NEAR(walk.elevation(3), -30, 1e-9);
  EXPECT_THAT(walk.places(4), ElementsAre(0, 3));
  EXPECT_THAT(walk.places(5), ElementsAre(0));  // `end` adds no entry
  EXPECT_THAT(walk.environment().ended(), ElementsAre(0, 0, 0, 0, 0, 1));
}

TEST(R2rEnvironment, ElevationIsClampedAndTheHeadingOfTheStartSnapped) {
  const tasks::EpisodeSet set = episodes_on(graph::testing::square(), {{0, 3, 44}, {0, 3, 46}});
  Walk walk(set);
  EXPECT_NEAR(walk.heading(0), 30, 1e-9);
  EXPECT_NEAR(walk.heading(1), 60, 1e-9);
  for (int i = 0; i < 3; ++i) walk.step({kUp, kDown});
  EXPECT_NEAR(walk.elevation(0), 30, 1e-9);
  EXPECT_NEAR(walk.elevation(1), -30, 1e-9);
}

TEST(R2rEnvironment, ForwardIsClosedWhereNothingIsAheadAndThenStays) {
  // From corner 0 the others are north and east; south-west there is nothing.
  const tasks::EpisodeSet set = episodes_on(graph::testing::square(), {{0, 2, 0}, {0, 2, 210}});
  Walk walk(set);
  EXPECT_THAT(walk.open(), ElementsAre(1, 0));
  walk.step({kForward, kForward});
  EXPECT_THAT(walk.places(1), ElementsAre(0, 0));
}

TEST(R2rEnvironment, InputsThatAreNoActionsStay) {
  const tasks::EpisodeSet set = episodes_on(graph::testing::square(), {{0, 3, 0}, {0, 3, 0}});
  Walk walk(set);
  EXPECT_TRUE(walk.step({kIgnoreInput, kStartInput}));
  EXPECT_THAT(walk.places(0), ElementsAre(0, 0));
  EXPECT_THAT(walk.environment().ended(), ElementsAre(0, 0));
}

TEST(R2rEnvironment, LabelsFollowTheTeacher) {
  const tasks::EpisodeSet set = episodes_on(
      graph::testing::square(), {{0, 3, 0}, {0, 3, 90}, {0, 3, 270}, {0, 0, 0}, {0, 3, 180}});
  Walk walk(set);
  // North is ahead; to the left; to the right; here; and as far either way, which is right.
  EXPECT_EQ(walk.labels(), (Labels{kForward, kLeft, kRight, kEnd, kRight}));
}

TEST(R2rEnvironment, LabelsLookUpAndDownStairs) {
  const double rise = std::sqrt(3.0);  // 60 degrees over 1 m
  const tasks::EpisodeSet set =
      episodes_on(graph::testing::connectivity("s", {{0, 0, 0}, {0, 1, rise}, {0, -1, -rise}},
                                               {{0, 1}, {0, 2}}),
                  {{0, 1, 0}, {0, 2, 180}});
  Walk walk(set);
  EXPECT_EQ(walk.labels(), (Labels{kUp, kDown}));
  walk.step({kUp, kDown});
  EXPECT_EQ(walk.labels(), (Labels{kForward, kForward}));
}

TEST(R2rEnvironment, WhoEndedAwayFromTheGoalIsLabelledAndMovedAsInTheReleasedCode) {
  const tasks::EpisodeSet set = episodes_on(graph::testing::square(), {{0, 3, 0}, {0, 3, 90}});
  Walk walk(set);
  walk.step({kEnd, kLeft});
  EXPECT_EQ(walk.labels()[0], kForward);
  walk.step({kForward, kLeft});
  // It is at the goal now, and over; its recorded path still is the start alone.
  EXPECT_EQ(walk.labels()[0], kIgnoreLabel);
  EXPECT_THAT(walk.places(0), ElementsAre(0));
  walk.step({kLeft, kLeft});  // moves on the spot: still at the goal
  EXPECT_EQ(walk.labels()[0], kIgnoreLabel);
}

TEST(R2rEnvironment, WhoEndedStaysIfSoWished) {
  const tasks::EpisodeSet set = episodes_on(graph::testing::square(), {{0, 3, 0}, {0, 3, 90}});
  Walk walk(set, models::AfterEnd::kStays);
  walk.step({kEnd, kLeft});
  EXPECT_EQ(walk.labels()[0], kIgnoreLabel);
  walk.step({kForward, kLeft});
  EXPECT_EQ(walk.labels()[0], kIgnoreLabel);
  EXPECT_FALSE(walk.step({kForward, kEnd}));
}

TEST(R2rEnvironment, ForwardLeadsToTheNearestOrToTheIntendedNeighbour) {
  // From v0 v1 is straight ahead and v2 25 degrees to the right; the goal is v2, within 30 degrees.
  const double a = degrees(25).value;
  const tasks::EpisodeSet set = episodes_on(
      graph::testing::connectivity(
          "s", {{0, 0, 0}, {0, 2, 0}, {3 * std::sin(a), 3 * std::cos(a), 0}}, {{0, 1}, {0, 2}}),
      {{0, 2, 0}});
  Walk nearest(set);
  EXPECT_EQ(nearest.labels(), Labels{kForward});
  nearest.step({kForward});
  EXPECT_THAT(nearest.places(0), ElementsAre(0, 1));
  Walk intended(set, models::AfterEnd::kWalksOn, models::ForwardTo::kIntended);
  intended.step({kForward});
  EXPECT_THAT(intended.places(0), ElementsAre(0, 2));
}

TEST(R2rEnvironment, HiddenGoalsLeaveNoTeacher) {
  tasks::EpisodeSet set = episodes_on(graph::testing::square(), {{0, 3, 0}});
  set.paths[0].viewpoints.resize(1);
  EXPECT_FALSE(R2rEnvironment(set, nullptr, {1}).has_teacher());
  EXPECT_THAT(
      [&] {
        R2rEnvironment(set, nullptr,
                       {1, 20, models::AfterEnd::kStays, models::ForwardTo::kIntended});
      },
      ThrowsMessage<ArgumentError>(HasSubstr("the goals of split made are hidden")));
}

TEST(R2rEnvironment, RefusesBatchesThatDoNotFit) {
  const tasks::EpisodeSet set = episodes_on(graph::testing::square(), {{0, 3, 0}});
  R2rEnvironment environment(set, nullptr, {2});
  EXPECT_THAT([&] { environment.start(std::vector<std::size_t>{0}); },
              ThrowsMessage<ArgumentError>(HasSubstr("1 episodes for a batch of 2")));
  EXPECT_THAT(
      [&] {
        environment.start(std::vector<std::size_t>{0, 1});
      },
      ThrowsMessage<ArgumentError>(HasSubstr("episode 1: split made has 1")));
}

TEST(R2rEnvironment, ShowsTheFeatureOfTheViewThatEachAgentHas) {
  const tests::TemporaryFolder folder("environment");
  const tasks::EpisodeSet set = episodes_on(graph::testing::square(), {{0, 3, 0}, {2, 0, 0}});
  const std::filesystem::path file = folder.path() / "f.safetensors";
  features::FeatureInfo info;
  info.dimensions = 2;
  // Viewpoints in another order than the graph's: number v gives (v, view).
  features::FeatureWriter writer = features::FeatureWriter::create(
      file, info, {{"square", "v3"}, {"square", "v2"}, {"square", "v1"}, {"square", "v0"}});
  for (std::size_t row = 0; row < 4; ++row) {
    std::vector<float> views;
    for (int view = 0; view < 36; ++view) {
      views.push_back(static_cast<float>(3 - row));
      views.push_back(static_cast<float>(view));
    }
    writer.write(row, views);
  }
  writer.finish();
  const core::ViewFeatures features(features::FeatureSet::open(file), set);
  R2rEnvironment environment(set, &features, {2});
  EXPECT_EQ(environment.dimensions(), 2U);
  environment.start(std::vector<std::size_t>{0, 1});
  std::vector<float> seen(4);
  std::vector<std::uint8_t> open(2);
  environment.observe({seen, open, {}});
  EXPECT_THAT(seen, ElementsAre(0, 12, 2, 12));  // level, heading 0
  environment.step(std::vector<std::int32_t>{kRight, kUp});
  environment.observe({seen, open, {}});
  EXPECT_THAT(seen, ElementsAre(0, 13, 2, 24));
}

TEST(ViewFeatures, NamesViewpointsThatAreMissing) {
  const tests::TemporaryFolder folder("features");
  const tasks::EpisodeSet set = episodes_on(graph::testing::square(), {{0, 3, 0}});
  const std::filesystem::path file = folder.path() / "f.safetensors";
  features::FeatureInfo info;
  info.dimensions = 1;
  features::FeatureWriter writer =
      features::FeatureWriter::create(file, info, {{"square", "v0"}, {"square", "v2"}});
  for (std::size_t row = 0; row < 2; ++row) writer.write(row, std::vector<float>(36));
  writer.finish();
  EXPECT_THAT([&] { core::ViewFeatures(features::FeatureSet::open(file), set); },
              ThrowsMessage<InvalidInput>(HasSubstr("2 viewpoints that agents may come to in split "
                                                    "made: square_v1, square_v3")));
}

// Walks a whole split by the environment's own labels.
struct Imitation {
  double success = 0, length = 0, stopped = 0, actions = 0;
  std::size_t most_actions = 0;
};

Imitation imitate(const tasks::EpisodeSet& set, models::ForwardTo forward, std::size_t max_steps) {
  Imitation result;
  std::vector<tasks::Trajectory> all;
  const std::size_t total = set.episodes.size();
  for (std::size_t first = 0; first < total; first += 500) {
    const std::size_t n = std::min<std::size_t>(500, total - first);
    R2rEnvironment environment(set, nullptr, {n, max_steps, models::AfterEnd::kWalksOn, forward});
    std::vector<std::size_t> batch(n);
    std::iota(batch.begin(), batch.end(), first);
    environment.start(batch);
    std::vector<std::uint8_t> open(n);
    Labels labels(n);
    bool more = true;
    for (std::size_t step = 0; step < max_steps && more; ++step) {
      environment.observe({{}, open, labels});
      more = environment.step(labels);
    }
    for (std::size_t i = 0; i < n; ++i) {
      all.push_back(environment.trajectories()[i]);
      if (environment.ended()[i] == 0) continue;
      result.stopped += 1;
      const std::size_t actions = all.back().points.size();  // `end` adds none, the start does
      result.actions += static_cast<double>(actions);
      result.most_actions = std::max(result.most_actions, actions);
    }
  }
  for (const tasks::EpisodeMetrics& m : score_trajectories(all, set, {}, 0)) {
    result.success += m.success;
    result.length += m.trajectory_length;
  }
  for (double* value : {&result.success, &result.length, &result.stopped, &result.actions}) {
    *value /= static_cast<double>(total);
  }
  return result;
}

// What was measured elsewhere, by a program of another author, to the digits given: success, length
// and actions rounded. Who stops within the 20 actions is given in whole percent, cut off: it is
// 86.57, 85.00 and 85.31 % here, by instructions and by paths alike, and with 19 actions it would
// be 83.8, 80.0 and 82.6 %, which no rounding makes 86, 85 and 85.
TEST(RealData, APerfectImitatorReachesTheCeilingOfTheSixActions) {
  const auto data = scan::DataRoot::from_environment();
  if (!data) GTEST_SKIP() << "ENFILADE_DATA is not set: no R2R annotations";
  const auto graphs = graph::GraphSet::open(data->connectivity());
  struct Row {
    const char* split;
    double success, length, stopped, intended_actions;
  };
  for (const Row& row :
       {Row{"train", 97.3, 10.79, 86, 12.0}, Row{"val_seen", 97.4, 11.05, 85, 11.9},
        Row{"val_unseen", 95.9, 10.17, 85, 12.8}}) {
    const tasks::EpisodeSet set =
        make_episodes(tasks::load_annotations(data->annotations(row.split), row.split), graphs);
    const Imitation six = imitate(set, models::ForwardTo::kNearest, 20);
    EXPECT_NEAR(100 * six.success, row.success, 0.05 + 1e-9) << row.split;
    EXPECT_NEAR(six.length, row.length, 0.005 + 1e-9) << row.split;
    EXPECT_EQ(std::floor(100 * six.stopped + 1e-9), row.stopped) << row.split;
    const Imitation intended = imitate(set, models::ForwardTo::kIntended, 40);
    EXPECT_EQ(intended.success, 1) << row.split;
    EXPECT_EQ(intended.stopped, 1) << row.split;
    EXPECT_NEAR(intended.actions, row.intended_actions, 0.05 + 1e-9) << row.split;
    EXPECT_LE(intended.most_actions, 35U) << row.split;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::seq2seq
