#include "enfilade/neural/train.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <cmath>
#include <csignal>
#include <nlohmann/json.hpp>

#include <stdexcept>

#include "enfilade/agents/run.h"
#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/core/part_file.h"
#include "enfilade/neural/device.h"
#include "enfilade/neural/seq2seq/evaluation.h"
#include "enfilade/neural/speaker.h"
#include "enfilade/neural/trained_agent.h"
#include "enfilade/tasks/score_table.h"
#include "tests/support/refusal.h"
#include "tests/support/small_training.h"

namespace enfilade::neural {
namespace EN_UNIT {
namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

constexpr std::array<models::AgentKind, 3> kKinds{
    models::AgentKind::kSeq2Seq, models::AgentKind::kPanoramic, models::AgentKind::kDuet};

class TrainerTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { small_ = std::make_unique<tests::SmallTraining>(); }
  static void TearDownTestSuite() { small_.reset(); }

  fs::path fresh(const std::string& name) const {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    return small_->model(std::string(test->name()) + "_" + name);
  }
  bool train_into(const fs::path& folder, const models::TrainConfig& config) const {
    return small_->train(folder, config);
  }
  void train_until(const fs::path& folder, const models::TrainConfig& config,
                   std::uint64_t stop) const {
    small_->train_until(folder, config, stop);
  }
  static std::string weights(const fs::path& folder) { return tests::weights_of(folder); }
  static std::vector<nlohmann::json> log(const fs::path& folder) { return tests::log_of(folder); }

  static std::unique_ptr<tests::SmallTraining> small_;
};
std::unique_ptr<tests::SmallTraining> TrainerTest::small_;

TEST_F(TrainerTest, LeavesAModelDirectory) {
  const fs::path folder = fresh("model");
  EXPECT_TRUE(train_into(folder, small_->config()));
  const seq2seq::Model model = seq2seq::load_model(folder);
  EXPECT_EQ(model.iteration, 12U);
  EXPECT_EQ(model.config.training.network.features, small_->kDimensions);
  EXPECT_EQ(model.config.training.network.vocabulary, model.vocabulary.size());
  std::vector<std::string> lines;
  for (const auto& line : log(folder)) {
    lines.push_back(line["type"].get<std::string>() + line["iteration"].dump());
  }
  EXPECT_THAT(lines, ElementsAre("train5", "evaluation6", "evaluation6", "train10", "train12",
                                 "evaluation12", "evaluation12"));
}

TEST_F(TrainerTest, ResultsAreThoseOfTheLastEvaluation) {
  const fs::path folder = fresh("model");
  train_into(folder, small_->config());
  const auto data = small_->load(small_->config());
  for (std::size_t k = 0; k < 2; ++k) {
    const tasks::EpisodeSet& split = data.graph().validation[k];
    const auto results = load_results(models::ModelFiles{folder}.results(split.split), split);
    const auto score = compute_score(results.trajectories, split);
    const auto line = log(folder).at(5 + k);
    EXPECT_EQ(line["split"], split.split);
    EXPECT_EQ(line["episodes"], split.episodes.size());
    EXPECT_EQ(line["success_rate"], score.mean("success").mean);
    EXPECT_EQ(line["nav_error"], score.mean("nav_error").mean);
    EXPECT_EQ(line["spl"], score.mean("spl").mean);
    EXPECT_GT(line["loss"], 0);
  }
}

TEST_F(TrainerTest, TheSameSeedGivesTheSameBytesAndAnotherOnesOthers) {
  models::TrainConfig config = small_->config();
  train_into(fresh("a"), config);
  train_into(fresh("b"), config);
  config.seed = 2;
  train_into(fresh("c"), config);
  EXPECT_EQ(weights(fresh("a")), weights(fresh("b")));
  EXPECT_EQ(log(fresh("a")), log(fresh("b")));
  EXPECT_NE(weights(fresh("a")), weights(fresh("c")));
}

// At sizes as small as these OpenBLAS gives the same at any number of threads; MKL, which is inside
// PyPI's PyTorch, only with one number of them.
TEST_F(TrainerTest, ThreadsChangeNothing) {
  const std::string blas = examine_torch().blas;
  set_threads(2);
  train_into(fresh("two"), small_->config());
  train_into(fresh("again"), small_->config());
  EXPECT_EQ(weights(fresh("two")), weights(fresh("again")));
  if (blas.find("openblas") != std::string::npos) {
    set_threads(1);
    train_into(fresh("one"), small_->config());
    EXPECT_EQ(weights(fresh("one")), weights(fresh("two")));
  }
  set_threads(0);
}

// Each way in which each agent is trained.
std::vector<models::TrainConfig> ways_to_train() {
  std::vector<models::TrainConfig> ways;
  for (const models::AgentKind agent : kKinds) {
    for (const models::Feedback feedback :
         {models::Feedback::kSample, models::Feedback::kTeacher}) {
      ways.push_back(tests::SmallTraining::config(agent));
      ways.back().feedback = feedback;
    }
  }
  models::TrainConfig labels = tests::SmallTraining::config(models::AgentKind::kPanoramic);
  labels.sampled_loss = models::SampledLoss::kLabels;
  labels.optimizer = models::Optimizer::kAdamW;
  labels.schedule = models::Schedule::kLinear;
  labels.warm_up = 4;
  ways.push_back(labels);
  return ways;
}

TEST_F(TrainerTest, GoesOnToTheBitAfterBeingStoppedAnywhere) {
  std::size_t way = 0;
  for (const models::TrainConfig& config : ways_to_train()) {
    const std::string name = std::to_string(way++) + std::string(to_string(config.agent));
    const fs::path whole = fresh(name), stopped = fresh(name + "_stopped");
    train_into(whole, config);
    // Before the first checkpoint, between two, right after one, and between evaluation and end.
    for (const std::uint64_t stop : {3U, 7U, 10U, 12U}) train_until(stopped, config, stop);
    EXPECT_TRUE(train_into(stopped, config));
    EXPECT_EQ(weights(stopped), weights(whole)) << name;
    EXPECT_EQ(log(stopped), log(whole)) << name;
  }
}

// The viewpoints of a trajectory, each once where the agent stays.
std::vector<ViewpointIndex> places(const tasks::Trajectory& trajectory) {
  std::vector<ViewpointIndex> places;
  for (const tasks::TrajectoryPoint& point : trajectory.points) {
    if (places.empty() || places.back() != point.viewpoint) places.push_back(point.viewpoint);
  }
  return places;
}

TEST_F(TrainerTest, AgentsWalkStepByStepAsInWholeSplits) {
  const features::FeatureSet features = features::FeatureSet::open(small_->features());
  for (const models::AgentKind kind : kKinds) {
    const models::TrainConfig config = small_->config(kind);
    const fs::path folder = fresh(std::string(to_string(kind)));
    train_into(folder, config);
    const auto agent = load_trained_agent(folder);
    EXPECT_EQ(agent->name(), to_string(kind));
    EXPECT_EQ(agent->iteration(), 12U);
    const auto data = small_->load(config);
    for (const tasks::EpisodeSet& split : data.graph().validation) {
      agent->enter(split, &features);
      const auto whole = agent->walk({16}, {});
      const auto results = load_results(models::ModelFiles{folder}.results(split.split), split);
      for (const std::size_t batch : {100U, 7U}) {
        agents::RunOptions run;
        run.batch_size = batch;
        const auto steps = agents::run_agent(*agent, split, run);
        ASSERT_EQ(steps.size(), whole.size());
        for (std::size_t i = 0; i < whole.size(); ++i) {
          EXPECT_EQ(places(steps[i]), places(whole[i])) << to_string(kind) << " " << i;
          EXPECT_EQ(places(results.trajectories[i]), places(whole[i])) << to_string(kind);
        }
      }
    }
  }
}

TEST_F(TrainerTest, APanoramicAgentsConfigIsReadBack) {
  const models::TrainConfig config = small_->config(models::AgentKind::kPanoramic);
  const fs::path folder = fresh("model");
  train_into(folder, config);
  const auto there = models::load_model_config(models::ModelFiles{folder}.config()).training;
  EXPECT_EQ(there.agent, models::AgentKind::kPanoramic);
  EXPECT_EQ(there.panoramic.subout, models::Subout::kOwnMax);
  EXPECT_EQ(there.panoramic.hidden, 8U);
  EXPECT_EQ(there.optimizer, models::Optimizer::kRmsProp);
  EXPECT_THAT([&] { seq2seq::load_model(folder); },
              ThrowsMessage<ArgumentError>(HasSubstr("an agent panoramic, not seq2seq")));
  EXPECT_THAT([&] { load_trained_agent(folder, "gpu"); },
              ThrowsMessage<ArgumentError>(HasSubstr("\"cuda:N\" for card N")));
  EXPECT_THAT([&] { train_into(folder, small_->config()); },
              ThrowsMessage<ArgumentError>(HasSubstr("agent: panoramic, not seq2seq")));
}

TEST_F(TrainerTest, SaysWhichPrecisionThereIs) {
  const models::TrainConfig config = small_->config();
  const auto training = [&](const Computing& computing) {
    return [&, computing] { train(config, small_->load(config), fresh("model"), computing); };
  };
  EXPECT_THAT(
      training({"cpu", Precision::kTf32}),
      ThrowsMessage<ArgumentError>(HasSubstr("precision tf32: the CPU computes in float32 alone")));
  EXPECT_THAT(training({"cuda", Precision::kBfloat16}),
              ThrowsMessage<ArgumentError>(HasSubstr(
                  "precision bfloat16: the agent seq2seq is trained in float32 or tf32")));
  EXPECT_FALSE(fs::exists(fresh("model") / "config.json"));
  for (const auto value : {Precision::kFloat32, Precision::kTf32, Precision::kBfloat16}) {
    EXPECT_EQ(models::parse_name<Precision>("precision", enum_name(value)), value);
  }
  EXPECT_THAT([] { models::parse_name<Precision>("precision", "half"); },
              ThrowsMessage<ArgumentError>(HasSubstr("float32 or tf32 or bfloat16 is allowed")));
}

TEST_F(TrainerTest, ASpeakerIsTrainedToTheBitAndDescribesPaths) {
  const models::TrainConfig config = small_->config(models::AgentKind::kSpeaker);
  const fs::path whole = fresh("whole");
  train_into(whole, config);
  for (const std::uint64_t stop : {3U, 7U, 12U}) {
    const fs::path folder = fresh(std::to_string(stop));
    train_until(folder, config, stop);
    EXPECT_TRUE(train_into(folder, config));
    EXPECT_EQ(weights(folder), weights(whole)) << stop;
    EXPECT_EQ(log(folder), log(whole)) << stop;
  }
  const auto lines = log(whole);
  EXPECT_EQ(lines.at(1)["type"], "speaker");
  EXPECT_LT(lines.at(5)["loss"], lines.at(1)["loss"]) << "it learns";
  const features::FeatureSet features = features::FeatureSet::open(small_->features());
  Speaker speaker(whole);
  EXPECT_EQ(speaker.iteration(), 12U);
  const auto data = small_->load(config);
  const models::SpeakerRecord score = speaker.score(data.graph().validation[0], &features, 16);
  EXPECT_NEAR(score.loss, lines.at(5)["loss"].get<double>(), 1e-5);
  EXPECT_NEAR(score.perplexity, std::exp(score.loss), 1e-9);
  const auto texts = speaker.describe(data.graph().training, &features, {});
  ASSERT_EQ(texts.size(), data.graph().training.paths.size());
  EXPECT_EQ(texts, speaker.describe(data.graph().training, &features, {}));
  SpeakOptions drawn;
  drawn.drawn = 5;
  EXPECT_NE(texts, speaker.describe(data.graph().training, &features, drawn));
  EXPECT_THAT([&] { load_trained_agent(whole); },
              ThrowsMessage<ArgumentError>(HasSubstr("a speaker, which describes paths")));
  EXPECT_THAT([&] { speaker.describe(data.graph().training, nullptr, {}); },
              ThrowsMessage<ArgumentError>(HasSubstr("needs features")));
  train_into(fresh("listener"), small_->config(models::AgentKind::kPanoramic));
  EXPECT_THAT([&] { Speaker(fresh("listener")); },
              ThrowsMessage<ArgumentError>(HasSubstr("an agent panoramic, not a speaker")));
}

TEST_F(TrainerTest, TrainsInTheFirstBuildingsAlone) {
  models::TrainConfig config = small_->config();
  config.splits = {"train", "val_unseen"};  // the small set has one building in each
  const tasks::EpisodeSet all = small_->load(config).graph().training;
  config.buildings = 1;
  const tasks::EpisodeSet one = small_->load(config).graph().training;
  ASSERT_FALSE(one.episodes.empty());
  ASSERT_LT(one.episodes.size(), all.episodes.size());
  for (std::size_t i = 0; i < one.episodes.size(); ++i) {
    EXPECT_EQ(one.episodes[i].instruction_id, all.episodes[i].instruction_id);
    EXPECT_EQ(one.path_of(one.episodes[i]).scan, all.paths.front().scan);
  }
  const fs::path folder = fresh("model");
  train_into(folder, config);
  EXPECT_EQ(models::load_model_config(models::ModelFiles{folder}.config()).training.buildings, 1U);
  config.buildings = std::nullopt;
  EXPECT_THAT([&] { train_into(folder, config); },
              ThrowsMessage<ArgumentError>(HasSubstr("buildings: 1, not none")));
  config.buildings = 3;
  EXPECT_THAT(
      [&] { small_->load(config); },
      ThrowsMessage<ArgumentError>(HasSubstr("buildings: 3, but split train+val_unseen has 2")));
}

TEST_F(TrainerTest, EvaluationChangesNoWeight) {
  models::TrainConfig config = small_->config();
  train_into(fresh("with"), config);
  config.evaluate_every = 0;
  train_into(fresh("without"), config);
  EXPECT_EQ(weights(fresh("with")), weights(fresh("without")));
}

TEST_F(TrainerTest, IsDoneWhenItIsDoneAndCanBeMadeLonger) {
  models::TrainConfig config = small_->config();
  train_into(fresh("short"), config);
  EXPECT_FALSE(train_into(fresh("short"), config));
  config.iterations = 20;
  EXPECT_TRUE(train_into(fresh("short"), config));
  train_into(fresh("long"), config);
  EXPECT_EQ(weights(fresh("short")), weights(fresh("long")));
}

TEST_F(TrainerTest, WritesWeightsThatAKillLeftBehind) {
  const fs::path folder = fresh("model");
  train_into(folder, small_->config());
  const std::string before = weights(folder);
  fs::remove(models::ModelFiles{folder}.weights());
  EXPECT_FALSE(train_into(folder, small_->config()));
  EXPECT_EQ(weights(folder), before);
}

TEST_F(TrainerTest, RefusesToGoOnWithOtherOptionsOrData) {
  const fs::path folder = fresh("model");
  models::TrainConfig config = small_->config();
  train_into(folder, config);
  config.network.hidden = 9;
  config.seed = 5;
  EXPECT_THAT([&] { train_into(folder, config); },
              ThrowsMessage<ArgumentError>(AllOf(HasSubstr("was trained otherwise"),
                                                 HasSubstr("hidden: 8, not 9"),
                                                 HasSubstr("seed: 1, not 5"))));
  config = small_->config();
  TrainingData data = small_->load(config);
  data.fingerprint.graphs.begin()->second = "other";
  EXPECT_THAT([&] { train(config, data, folder); },
              ThrowsMessage<ArgumentError>(HasSubstr("here it is other")));
  data = small_->load(config);
  data.graph().training.episodes[0].text = "word word word word word";
  EXPECT_THAT([&] { train(config, data, folder); },
              ThrowsMessage<ArgumentError>(HasSubstr("vocabulary")));
}

TEST_F(TrainerTest, RefusesFeaturesOfAnotherSizeThanTheModels) {
  const fs::path folder = fresh("model"), other = small_->model("other.safetensors");
  const models::TrainConfig config = small_->config();
  train_into(folder, config);
  small_->write_features(other, 4);
  EXPECT_THAT([&] { train(config, load_training_data(small_->root(), config, other), folder); },
              ThrowsMessage<ArgumentError>(HasSubstr("features: 5, not 4")));
}

TEST_F(TrainerTest, NeedsFeaturesOnlyToSee) {
  models::TrainConfig config = small_->config();
  EXPECT_THAT([&] { load_training_data(small_->root(), config, std::nullopt); },
              ThrowsMessage<ArgumentError>(HasSubstr("needs features")));
  for (const models::AgentKind kind : kKinds) {
    for (const char* inputs : {"language", "none"}) {
      config = small_->config(kind);
      config.network.inputs = models::parse_inputs(inputs);
      const fs::path folder = fresh(fmt::format("{}_{}", to_string(kind), inputs));
      EXPECT_TRUE(train(config, load_training_data(small_->root(), config, std::nullopt), folder));
      const auto agent = load_trained_agent(folder);
      EXPECT_EQ(agent->config().training.network.features, 0U);
    }
  }
}

TEST_F(TrainerTest, ABrokenCheckpointIsNamedAndTheOneBeforeGoesOnToTheBit) {
  const fs::path folder = fresh("model");
  const models::ModelFiles files{folder};
  train_into(fresh("whole"), small_->config());
  train_until(folder, small_->config(), 11);
  std::string bytes = read_file(files.checkpoint());
  bytes[bytes.size() / 2] = static_cast<char>(bytes[bytes.size() / 2] ^ 1);
  write_file_atomically(files.checkpoint(), bytes);
  EXPECT_THAT(
      [&] { train_into(folder, small_->config()); },
      ThrowsMessage<InvalidInput>(AllOf(HasSubstr("checkpoint.safetensors"),
                                        HasSubstr("remove it to go on from the one before"))));
  bytes.resize(bytes.size() / 3);  // cut off
  write_file_atomically(files.checkpoint(), bytes);
  EXPECT_THROW(train_into(folder, small_->config()), InvalidInput);
  fs::remove(files.checkpoint());
  train_into(folder, small_->config());
  EXPECT_EQ(weights(folder), weights(fresh("whole")));
}

// No file of this process may grow beyond `bytes` while it lives, as if the disk were full.
class FullDisk {
 public:
  explicit FullDisk(std::uintmax_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    EXPECT_EQ(getrlimit(RLIMIT_FSIZE, &before_), 0);
    const struct rlimit small {
      bytes, before_.rlim_max
    };
    EXPECT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  }
  FullDisk(const FullDisk&) = delete;
  FullDisk& operator=(const FullDisk&) = delete;
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  struct rlimit before_ {};
  void (*handler_)(int);
};

TEST_F(TrainerTest, ADiskThatFillsUpLeavesTheLastCheckpointWhole) {
  train_into(fresh("whole"), small_->config());
  struct Case {
    std::uintmax_t room;  // 0: a little less than a checkpoint
    const char* file;     // that does not fit
  };
  for (const Case& one :
       {Case{0, "checkpoint.safetensors"}, {5000, "results/"}, {1, "config.json"}}) {
    const fs::path folder = fresh(fmt::format("room_{}", one.room));
    const models::ModelFiles files{folder};
    train_until(folder, small_->config(), 6);  // with a checkpoint at 5
    std::string said;
    {
      models::TrainConfig config = small_->config();
      if (one.room == 0) config.evaluate_every = 0;  // its files are larger than a checkpoint
      const FullDisk disk(one.room > 0 ? one.room : fs::file_size(files.checkpoint()) - 100);
      said = tests::refusal<FileError>([&] { train_into(folder, config); });
    }
    EXPECT_THAT(said, HasSubstr(one.file)) << one.room;
    EXPECT_EQ(models::open_state(files.checkpoint()).iteration, 5U) << one.room;
    EXPECT_TRUE(train_into(folder, small_->config()));
    EXPECT_EQ(weights(folder), weights(fresh("whole"))) << one.room;
  }
}

TEST_F(TrainerTest, OneProcessAtATime) {
  const fs::path folder = fresh("model");
  make_folder(folder);
  const FolderLock lock(models::ModelFiles{folder}.lock());
  EXPECT_THAT([&] { train_into(folder, small_->config()); },
              ThrowsMessage<FileError>(HasSubstr("another process works in this folder")));
}

TEST_F(TrainerTest, SplitsToTrainOnAreJoined) {
  models::TrainConfig config = small_->config();
  const std::size_t train_only = small_->load(config).graph().training.episodes.size();
  config.splits = {"train", "val_seen", "val_unseen"};
  const TrainingData data = small_->load(config);
  const std::size_t others =
      data.graph().validation[0].episodes.size() + data.graph().validation[1].episodes.size();
  EXPECT_EQ(data.graph().training.episodes.size(), train_only + others);
  EXPECT_EQ(data.graph().training.split, "train+val_seen+val_unseen");
  // Each episode still has its own path.
  const tasks::Episode& last = data.graph().training.episodes.back();
  const tasks::Episode& same = data.graph().validation[1].episodes.back();
  EXPECT_EQ(last.instruction_id, same.instruction_id);
  EXPECT_EQ(data.graph().training.path_of(last).viewpoints,
            data.graph().validation[1].path_of(same).viewpoints);
}

TEST_F(TrainerTest, HiddenGoalsCannotBeTrainedOn) {
  models::TrainConfig config = small_->config();
  config.splits = {"test"};
  EXPECT_THAT([&] { small_->load(config); },
              ThrowsMessage<ArgumentError>(HasSubstr("split test: its goals are hidden")));
}

TEST_F(TrainerTest, TellsHowFarItIs) {
  models::TrainConfig config = small_->config();
  std::vector<std::uint64_t> iterations;
  std::size_t evaluations = 0;
  TrainingListener listener;
  listener.iteration = [&](const TrainingProgress& progress) {
    iterations.push_back(progress.iteration);
    EXPECT_EQ(progress.iterations, 12U);
    EXPECT_GT(progress.loss, 0);
    EXPECT_GT(progress.data_share, 0);
    EXPECT_LT(progress.data_share, 1);
  };
  listener.evaluation = [&](const models::EvaluationRecord&) { ++evaluations; };
  train(config, small_->load(config), fresh("model"), {}, listener);
  EXPECT_THAT(iterations, ElementsAre(1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12));
  EXPECT_EQ(evaluations, 4U);
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural
