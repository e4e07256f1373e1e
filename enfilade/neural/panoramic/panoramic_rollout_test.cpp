#include "enfilade/neural/panoramic/panoramic_episode.h"

#include <ATen/ATen.h>
#include <c10/core/GradMode.h>
#include <gmock/gmock.h>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/neural/core/optimizer.h"
#include "tests/support/graphs.h"

namespace enfilade::neural::panoramic {
namespace EN_UNIT {

using ::testing::ElementsAre;

PanoramicConfig small() {
  PanoramicConfig config;
  config.vocabulary = 20;
  config.word_embedding = 6;
  config.action_embedding = 5;
  config.hidden = 8;
  config.image = 3;
  config.angle = 4;
  config.dropout = 0;
  config.feature_dropout = 0;
  return config;
}

// Five viewpoints in a row to the north, 2 m apart, and one to the east of the first.
class PanoramicRolloutTest : public ::testing::Test {
 protected:
  static std::shared_ptr<const graph::GraphSet> made() {
    const std::vector<Vec3d> points{{0, 0, 1.5}, {0, 2, 1.5}, {0, 4, 1.5},
                                    {0, 6, 1.5}, {0, 8, 1.5}, {2, 0, 1.5}};
    const std::vector<std::pair<int, int>> edges{{0, 1}, {1, 2}, {2, 3}, {3, 4}, {0, 5}};
    std::vector<graph::NavGraph> graphs;
    graphs.emplace_back(graph::testing::connectivity("made", points, edges));
    return graph::GraphSet::of(std::move(graphs));
  }
  PanoramicEpisode walk(std::size_t from, std::optional<std::size_t> to, double heading = 0) {
    std::optional<ViewpointIndex> goal;
    if (to) goal = ViewpointIndex(*to);
    return {panoramas_, *graphs_, {{ScanIndex(0), ViewpointIndex(from)}, Radians(heading), goal}};
  }
  static void pictures(graph::Location at, std::uint32_t view, std::span<float> out) {
    for (std::size_t c = 0; c < out.size(); ++c) {
      out[c] =
          static_cast<float>(std::sin(static_cast<double>(at.viewpoint.at() * 100 + view * 3 + c)));
    }
  }

  std::shared_ptr<const graph::GraphSet> graphs_ = made();
  agents::PanoramaCache panoramas_{graphs_};
};

TEST_F(PanoramicRolloutTest, TurnsRightOnlyAndKeepsItsView) {
  PanoramicEpisode walks = walk(0, 4, kPi / 6);
  ASSERT_EQ(walks.stop(), 2U);
  EXPECT_EQ(walks.teacher(), walks.candidates()[0].viewpoint == ViewpointIndex(1) ? 0U : 1U);
  walks.choose(walks.teacher());
  EXPECT_EQ(walks.location().viewpoint, ViewpointIndex(1));
  const std::uint32_t view = walks.view();
  EXPECT_EQ(view % 12, 0U) << "north";
  // From heading 1 a whole turn but one to the right, perhaps one up or down, and the move.
  EXPECT_EQ(walks.trajectory().size(), 1U + 11U + (view / 12 == 1 ? 0U : 1U) + 1U);
  EXPECT_NEAR(walks.distance(), 6, 1e-6);
  walks.choose(walks.stop());
  EXPECT_TRUE(walks.ended());
}

TEST_F(PanoramicRolloutTest, LookSeesHeadingsFromTheAgentsView) {
  const std::vector<PanoramicEpisode> walks{walk(0, 4, kPi / 2), walk(2, 4)};
  const StepInput input = look(walks, small(), pictures);
  EXPECT_NEAR(input.action[0][0].item<double>(), 1, 1e-6);
  EXPECT_NEAR(input.action[0][1].item<double>(), 0, 1e-6);
  // View 15 is where the first agent looks; elevations are absolute.
  EXPECT_NEAR(input.views[0][15][3].item<double>(), 0, 1e-6);
  EXPECT_NEAR(input.views[0][15][4].item<double>(), 1, 1e-6);
  EXPECT_NEAR(input.views[0][3][5].item<double>(), -0.5, 1e-6);
  EXPECT_NEAR(input.views[0][3][0].item<double>(), std::sin(9.0), 1e-6);
  EXPECT_EQ(input.candidates.size(1), 3);
  EXPECT_EQ(input.candidates[1][2].abs().sum().item<double>(), 0) << "stop";
  EXPECT_FALSE(input.closed.any().item<bool>()) << "both have two neighbours";
}

// Made by lookups on the pictures' device, as cards do it.
TEST_F(PanoramicRolloutTest, LookOfResidentPicturesIsTheSame) {
  const std::vector<PanoramicEpisode> walks{walk(0, 4, kPi / 2), walk(2, 4), walk(5, 3, 1),
                                            walk(0, 1)};
  const auto columns = static_cast<std::int64_t>(small().image);
  std::size_t sent = 0;
  core::ResidentViews resident(columns, at::kCPU, [&](graph::Location at, std::span<float> out) {
    ++sent;
    for (std::uint32_t view = 0; view < core::ResidentViews::kViews; ++view) {
      pictures(at, view, out.subspan(view * small().image, small().image));
    }
  });
  for (int again = 0; again < 2; ++again) {
    const StepInput there = look(walks, small(), resident), here = look(walks, small(), pictures);
    EXPECT_TRUE(there.action.equal(here.action));
    EXPECT_TRUE(there.views.equal(here.views));
    EXPECT_TRUE(there.candidates.equal(here.candidates));
    EXPECT_TRUE(there.closed.equal(here.closed));
  }
  EXPECT_EQ(sent, 3U) << "two stand at one viewpoint, and all came once";
}

TEST(ResidentViewsTest, KeepsWhatItHasWhenItGrows) {
  constexpr std::size_t kPlaces = 200;  // more than the first table has rows for
  core::ResidentViews resident(2, at::kCPU, [](graph::Location at, std::span<float> out) {
    for (std::size_t i = 0; i < out.size(); ++i) {
      out[i] = static_cast<float>(1000 * at.viewpoint.at() + i);
    }
  });
  std::vector<std::int64_t> rows;
  for (std::size_t place = 0; place < kPlaces; ++place) {
    rows.push_back(resident.first_row({ScanIndex(0), ViewpointIndex(place)}) + 35);
    if (place % 30 == 0) (void)resident.gather({rows.back()});
  }
  rows.push_back(core::ResidentViews::kNothing);
  const at::Tensor found = resident.gather(rows);
  for (std::size_t place = 0; place < kPlaces; ++place) {
    const auto row = static_cast<std::int64_t>(place);
    EXPECT_EQ(found[row][1].item<double>(), 1000.0 * static_cast<double>(place) + 71);
  }
  EXPECT_EQ(found[static_cast<std::int64_t>(kPlaces)].abs().sum().item<double>(), 0);
}

TEST_F(PanoramicRolloutTest, TeacherLeadsToTheGoalAndStops) {
  PanoramicNetwork network(small(), 1);
  std::vector<PanoramicEpisode> walks{walk(5, 3), walk(1, 1)};
  PanoramicRolloutOptions options;
  options.feedback = models::Feedback::kTeacher;
  options.imitate = true;
  const std::vector<std::vector<std::int64_t>> sentences{{4, 5, 6, 2}, {7, 2}};
  double sum = 0;
  const RolloutLosses losses = roll_out(
      network, batch_words(sentences), walks, pictures, options, [&](const PanoramicStep& step) {
        const at::Tensor logs = at::log_softmax(step.output.logits, 1);
        for (std::int64_t i = 0; i < 2; ++i) {
          const auto row = static_cast<std::size_t>(i);
          if (step.walks[row].ended()) continue;
          sum -= logs[i][static_cast<std::int64_t>(step.choices[row])].item<double>();
        }
      });
  EXPECT_EQ(losses.steps, 5U) << "four moves and a stop";
  EXPECT_TRUE(walks[0].ended());
  EXPECT_EQ(walks[0].location().viewpoint, ViewpointIndex(3));
  EXPECT_EQ(walks[1].trajectory().size(), 1U);
  EXPECT_NEAR(losses.imitation.item<double>(), sum / 2, 1e-5);
}

// Rewards, returns and the loss, by hand, of a walk that is stopped by the limit.
TEST_F(PanoramicRolloutTest, ReturnsDiscountRewardsAndTheLastValue) {
  PanoramicNetwork network(small(), 1);
  std::vector<PanoramicEpisode> walks{walk(5, 4)};
  PanoramicRolloutOptions options;
  options.feedback = models::Feedback::kTeacher;
  options.reinforce = true;
  options.max_actions = 3;
  const std::vector<std::vector<std::int64_t>> sentences{{4, 2}};
  double expected = 0;
  std::vector<double> logs, entropies;
  const RolloutLosses losses = roll_out(
      network, batch_words(sentences), walks, pictures, options, [&](const PanoramicStep& step) {
        const at::Tensor log = at::log_softmax(step.output.logits, 1)[0];
        logs.push_back(log[static_cast<std::int64_t>(step.choices[0])].item<double>());
        const at::Tensor open = log.narrow(0, 0, std::ssize(step.walks[0].candidates()) + 1);
        entropies.push_back(-(open.exp() * open).sum().item<double>());
      });
  ASSERT_EQ(losses.rewards.size(), 3U);
  for (const auto& rewards : losses.rewards) EXPECT_THAT(rewards, ElementsAre(1));
  double next = losses.last_values[0];
  for (std::size_t t = 3; t-- > 0;) {
    next = 1 + 0.9 * next;
    EXPECT_NEAR(losses.returns[t][0], next, 1e-6);
    const double error = next - losses.values[t][0];
    expected += -logs[t] * error + 0.5 * error * error - 0.01 * entropies[t];
  }
  EXPECT_NEAR(losses.reinforcement.item<double>(), expected / 3, 1e-5);
}

TEST_F(PanoramicRolloutTest, AStopIsRewardedWithinThreeMetresOnly) {
  PanoramicNetwork network(small(), 1);
  std::vector<PanoramicEpisode> walks{walk(4, 4), walk(2, 3)};
  PanoramicRolloutOptions options;
  options.feedback = models::Feedback::kTeacher;
  options.reinforce = true;
  const std::vector<std::vector<std::int64_t>> sentences{{4, 2}, {5, 2}};
  const RolloutLosses losses = roll_out(network, batch_words(sentences), walks, pictures, options);
  EXPECT_THAT(losses.rewards, ElementsAre(ElementsAre(2, 1), ElementsAre(0, 2)));
  EXPECT_THAT(losses.active, ElementsAre(ElementsAre(1, 1), ElementsAre(0, 1)));
}

TEST_F(PanoramicRolloutTest, GradientsAreThoseOfFiniteDifferences) {
  PanoramicNetwork network(small(), 7);
  const std::vector<std::vector<std::int64_t>> sentences{{4, 5, 6, 2}, {7, 2}};
  const auto loss = [&] {
    std::vector<PanoramicEpisode> walks{walk(5, 4), walk(1, 0)};
    PanoramicRolloutOptions options;
    options.feedback = models::Feedback::kTeacher;
    options.imitate = true;
    return roll_out(network, batch_words(sentences), walks, pictures, options).imitation;
  };
  loss().backward();
  constexpr double kStep = 1e-2;
  for (const char* name : {"encoder.lstm.weight_hh_l0_reverse", "decoder.lstm.weight_ih",
                           "decoder.feat_att_layer.linear_in.weight", "decoder.embedding.0.bias"}) {
    const at::Tensor flat = network.weight(name).detach().view(-1);
    const c10::NoGradGuard guard;
    const double before = flat[3].item<double>();
    flat[3] = before + kStep;
    const double above = loss().item<double>();
    flat[3] = before - kStep;
    const double below = loss().item<double>();
    flat[3] = before;
    EXPECT_NEAR(network.weight(name).grad().view(-1)[3].item<double>(),
                (above - below) / (2 * kStep), 2e-3)
        << name;
  }
  EXPECT_FALSE(network.weight("critic.state2value.0.weight").grad().defined());
}

TEST_F(PanoramicRolloutTest, DrawsFollowTheSeed) {
  PanoramicNetwork network(small(), 1);
  const c10::NoGradGuard guard;
  const std::vector<std::vector<std::int64_t>> sentences{{4, 2}};
  const auto walked = [&](std::uint64_t seed) {
    std::vector<PanoramicEpisode> walks{walk(2, 4)};
    PanoramicRolloutOptions options;
    options.feedback = models::Feedback::kSample;
    options.seed = seed;
    roll_out(network, batch_words(sentences), walks, pictures, options);
    std::string path;
    for (const auto& point : walks[0].trajectory()) path += std::to_string(point.viewpoint.value);
    return path;
  };
  std::set<std::string> paths;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    paths.insert(walked(seed));
    EXPECT_EQ(walked(seed), walked(seed));
  }
  EXPECT_GT(paths.size(), 3U);
}

TEST_F(PanoramicRolloutTest, ALearnerLearnsToStop) {
  PanoramicNetwork network(small(), 1);
  models::TrainConfig fast = recipe(models::AgentKind::kPanoramic);
  fast.adam.learning_rate = 1e-2;
  core::WeightOptimizer optimizer(core::optimizer_of(fast, {"encoder.", "decoder."}));
  const std::vector<std::vector<std::int64_t>> sentences{{4, 5, 2}, {7, 2}};
  double first = 0, last = 0;
  for (int i = 0; i < 40; ++i) {
    std::vector<PanoramicEpisode> walks{walk(5, 4), walk(3, 0)};
    PanoramicRolloutOptions options;
    options.feedback = models::Feedback::kTeacher;
    options.imitate = true;
    const at::Tensor loss =
        roll_out(network, batch_words(sentences), walks, pictures, options).imitation;
    loss.backward();
    optimizer.update(network.weights());
    (i == 0 ? first : last) = loss.item<double>();
  }
  EXPECT_LT(last, first / 4);
  const auto state = optimizer.state(network.weights());
  EXPECT_EQ(
      state.at("optimizer.second.decoder.feat_att_layer.linear_out.weight").sum().item<double>(), 0)
      << "never takes part";
}

TEST_F(PanoramicRolloutTest, MissingGoalsAndOtherSizesAreTheCallersMistake) {
  PanoramicNetwork network(small(), 1);
  const std::vector<std::vector<std::int64_t>> sentences{{4, 2}};
  std::vector<PanoramicEpisode> hidden{walk(0, std::nullopt)};
  PanoramicRolloutOptions options;
  options.imitate = true;
  EXPECT_THROW(roll_out(network, batch_words(sentences), hidden, pictures, options), ArgumentError);
  std::vector<PanoramicEpisode> two{walk(0, 1), walk(0, 1)};
  EXPECT_THROW(roll_out(network, batch_words(sentences), two, pictures, {}), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::panoramic
