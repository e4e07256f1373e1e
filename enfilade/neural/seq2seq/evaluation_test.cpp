#include "enfilade/neural/seq2seq/evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "enfilade/agents/run.h"
#include "enfilade/core/file.h"
#include "tests/support/small_training.h"

namespace enfilade::neural::seq2seq {
namespace EN_UNIT {

namespace fs = std::filesystem;

// A model after a few updates, and the splits that it walks in.
class EvaluationTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    small_ = std::make_unique<tests::SmallTraining>();
    models::TrainConfig config = small_->config();
    config.evaluate_every = 0;
    train(config, small_->load(config), folder());
  }
  static void TearDownTestSuite() { small_.reset(); }

  static fs::path folder() { return small_->model("model"); }
  tasks::EpisodeSet episodes(const std::string& split) const {
    return make_episodes(small_->root().annotations(split), graphs_);
  }
  PreparedSplit prepared(const std::string& split) const {
    return prepare(episodes(split), model_.vocabulary, model_.config.training.network.max_words,
                   &features_);
  }
  BatchOptions options() const { return {16, model_.config.training.max_steps}; }

  static std::unique_ptr<tests::SmallTraining> small_;
  std::shared_ptr<const graph::GraphSet> graphs_ = small_->root().graphs();
  Model model_ = load_model(folder());
  features::FeatureSet features_ = features::FeatureSet::open(small_->features());
};
std::unique_ptr<tests::SmallTraining> EvaluationTest::small_;

bool same(const std::vector<tasks::Trajectory>& a, const std::vector<tasks::Trajectory>& b,
          const tasks::EpisodeSet& episodes) {
  return to_json(a, episodes) == to_json(b, episodes);
}

TEST_F(EvaluationTest, WalksEveryEpisodeOnceAndStopsInTime) {
  const PreparedSplit split = prepared("val_unseen");
  const GreedyRollout walk = rollout_greedily(*model_.network, split, options());
  ASSERT_EQ(walk.trajectories.size(), split.episodes.episodes.size());
  for (std::size_t i = 0; i < walk.trajectories.size(); ++i) {
    EXPECT_EQ(walk.trajectories[i].episode, i);
    const AttentionTrace& trace = walk.traces[i];
    const bool ended = trace.actions.back() == static_cast<std::int32_t>(SixAction::kStop);
    EXPECT_LE(trace.actions.size(), options().max_steps);
    EXPECT_EQ(walk.trajectories[i].points.size(), trace.actions.size() + (ended ? 0 : 1));
    for (const auto& attention : trace.attention) {
      double sum = 0;
      for (const float weight : attention) sum += weight;
      EXPECT_NEAR(sum, 1, 1e-5);  // a softmax in single precision, of at most 30 words
    }
  }
}

TEST_F(EvaluationTest, TheAgentMakesTheSameWalksAsTheBatch) {
  for (const char* name : {"val_seen", "test"}) {
    const PreparedSplit split = prepared(name);
    const GreedyRollout walk = rollout_greedily(*model_.network, split, options());
    Seq2SeqAgent agent(load_model(folder()));
    agent.enter(split.episodes, &features_);
    EXPECT_TRUE(same(agent.walk({options().batch_size}, {}), walk.trajectories, split.episodes));
    agents::RunOptions run;
    run.batch_size = options().batch_size;
    EXPECT_TRUE(
        same(agents::run_agent(agent, split.episodes, run), walk.trajectories, split.episodes))
        << name;
    run.batch_size = 7;  // batches of other sizes: sums of another order may differ in a last bit,
                         // which these logits are too far apart to show
    EXPECT_TRUE(
        same(agents::run_agent(agent, split.episodes, run), walk.trajectories, split.episodes))
        << name;
  }
}

TEST_F(EvaluationTest, LossIsTheSameEachTimeAndDependsOnTheStream) {
  const PreparedSplit split = prepared("val_seen");
  LossOptions loss{options(), {models::Feedback::kSample, 6, true, 1, 5}};
  const double first = compute_loss(*model_.network, split, loss);
  EXPECT_GT(first, 0);
  EXPECT_EQ(compute_loss(*model_.network, split, loss), first);
  loss.rollout.stream = 1000;
  EXPECT_NE(compute_loss(*model_.network, split, loss), first);
}

TEST_F(EvaluationTest, AttentionFilesSayWhatWasReadDoneAndSeen) {
  const PreparedSplit split = prepared("val_seen");
  const GreedyRollout walk = rollout_greedily(*model_.network, split, options());
  const fs::path file = small_->model("results") / "val_seen.attention.json";
  write_rollout({.results = file.parent_path() / "val_seen.json", .attention = file}, walk, split,
                model_.vocabulary, 6);
  const auto json = nlohmann::json::parse(read_file(file));
  EXPECT_GE(json.size(), 6U);
  EXPECT_LE(json.size(), 10U);  // six, two of the best, two of the worst
  for (std::size_t i = 0; i < 6; ++i) {
    const tasks::Episode& episode = split.episodes.episodes[i];
    const auto& one = json.at(episode.instruction_id);
    const models::ReadingOrder order =
        models::reading_order(split.instructions.row(i), model_.vocabulary);
    EXPECT_EQ(one["words"], order.words);
    ASSERT_EQ(one["steps"].size(), walk.traces[i].actions.size());
    for (std::size_t step = 0; step < one["steps"].size(); ++step) {
      const auto& said = one["steps"][step];
      const tasks::TrajectoryPoint& point = walk.trajectories[i].points[step];
      EXPECT_EQ(said["action"], to_string(SixAction{walk.traces[i].actions[step]}));
      EXPECT_EQ(said["viewpoint"], split.episodes.graph_of(episode).id(point.viewpoint));
      EXPECT_NEAR(said["heading"].get<double>(), point.heading.value,
                  1e-5);  // six digits are written
      ASSERT_EQ(said["attention"].size(), order.words.size());
      for (std::size_t k = 0; k < order.places.size(); ++k) {
        // Four digits after the point are written.
        EXPECT_NEAR(said["attention"][k].get<double>(),
                    walk.traces[i].attention[step][order.places[k]], 5.1e-5);
      }
    }
  }
}

TEST_F(EvaluationTest, AgentsThatSeeNeedFeaturesOfTheirSize) {
  const PreparedSplit split = prepared("val_seen");
  const auto agent = load_trained_agent(folder());
  EXPECT_THROW(agent->enter(split.episodes, nullptr), ArgumentError);
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::seq2seq
