#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/features/tensor_file.h"
#include "enfilade/neural/train.h"
#include "enfilade/neural/trained_agent.h"
#include "tests/support/small_training.h"

namespace enfilade::neural {
namespace EN_UNIT {

namespace fs = std::filesystem;
using models::AgentKind;
using models::ModelFiles;
using models::Stage;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class PretrainingTest : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { small_ = std::make_unique<tests::SmallTraining>(); }
  static void TearDownTestSuite() { small_.reset(); }

  static models::TrainConfig config(Stage stage) {
    models::TrainConfig config = tests::SmallTraining::config(AgentKind::kDuet);
    config.stage = stage;
    return config;
  }
  static fs::path fresh(const std::string& name) {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    return small_->model(std::string(test->name()) + "_" + name);
  }
  static bool train_into(const fs::path& folder, const models::TrainConfig& config,
                         const std::optional<fs::path>& from = {}) {
    return small_->train(folder, config, from);
  }
  static void train_until(const fs::path& folder, const models::TrainConfig& config,
                          std::uint64_t stop, const std::optional<fs::path>& from = {}) {
    small_->train_until(folder, config, stop, from);
  }
  static std::string weights(const fs::path& folder) { return tests::weights_of(folder); }
  static std::vector<nlohmann::json> log(const fs::path& folder) { return tests::log_of(folder); }

  static std::unique_ptr<tests::SmallTraining> small_;
};
std::unique_ptr<tests::SmallTraining> PretrainingTest::small_;

TEST_F(PretrainingTest, GoesOnToTheBitAfterBeingStoppedAnywhere) {
  const models::TrainConfig pretraining = config(Stage::kPretrain);
  const fs::path whole = fresh("whole"), stopped = fresh("stopped");
  train_into(whole, pretraining);
  for (const std::uint64_t stop : {3U, 7U, 10U, 12U}) train_until(stopped, pretraining, stop);
  EXPECT_TRUE(train_into(stopped, pretraining));
  EXPECT_EQ(weights(stopped), weights(whole));
  EXPECT_EQ(log(stopped), log(whole));
}

TEST_F(PretrainingTest, LeavesAModelThatWalks) {
  const fs::path folder = fresh("model");
  train_into(folder, config(Stage::kPretrain));
  EXPECT_EQ(models::load_model_config(ModelFiles{folder}.config()).training.stage,
            Stage::kPretrain);
  const auto agent = load_trained_agent(folder);
  EXPECT_EQ(agent->name(), "duet");
  EXPECT_EQ(agent->iteration(), 12U);
  const auto file = features::TensorFile::open(ModelFiles{folder}.weights());
  EXPECT_NE(file.find("mlm_head.predictions.bias"), nullptr);
  EXPECT_NE(file.find("vln_bert.global_sap_head.net.0.weight"), nullptr);
  for (const nlohmann::json& line : log(folder)) {
    if (line["type"] != "evaluation") continue;
    EXPECT_GT(line["loss"], 0);
  }
}

TEST_F(PretrainingTest, FineTuningBeginsWithTheWeightsOfAnotherModel) {
  train_into(fresh("pretrained"), config(Stage::kPretrain));
  models::TrainConfig still = config(Stage::kFineTune);
  still.adam.learning_rate = 0;
  train_into(fresh("tuned"), still, fresh("pretrained"));
  const auto before = features::TensorFile::open(ModelFiles{fresh("pretrained")}.weights());
  const auto after = features::TensorFile::open(ModelFiles{fresh("tuned")}.weights());
  ASSERT_FALSE(after.arrays().empty());
  for (const features::NamedArray& array : after.arrays()) {
    const features::NamedArray* was = before.find(array.name);
    ASSERT_NE(was, nullptr) << array.name;
    EXPECT_TRUE(std::ranges::equal(array.bytes, was->bytes)) << array.name;
  }
  EXPECT_EQ(read_file(ModelFiles{fresh("tuned")}.vocabulary()),
            read_file(ModelFiles{fresh("pretrained")}.vocabulary()));
  const auto training = models::load_model_config(ModelFiles{fresh("tuned")}.config()).training;
  EXPECT_EQ(training.initial_weights, before.metadata().at("hash"));
  EXPECT_EQ(training.stage, Stage::kFineTune);
}

TEST_F(PretrainingTest, BothStagesGoOnToTheBitFromAnotherModel) {
  const fs::path from = fresh("from");
  train_into(from, config(Stage::kPretrain));
  for (const Stage stage : {Stage::kFineTune, Stage::kPretrain}) {
    const std::string name(to_string(stage));
    train_into(fresh(name), config(stage), from);
    train_until(fresh(name + "7"), config(stage), 7, from);
    EXPECT_TRUE(train_into(fresh(name + "7"), config(stage), from));
    EXPECT_EQ(weights(fresh(name + "7")), weights(fresh(name)));
    train_into(fresh(name + "_new"), config(stage));
    EXPECT_NE(weights(fresh(name + "_new")), weights(fresh(name)));
  }
}

TEST_F(PretrainingTest, RefusesToGoOnFromAnotherModel) {
  train_into(fresh("from"), config(Stage::kPretrain));
  models::TrainConfig other = config(Stage::kPretrain);
  other.seed = 2;
  train_into(fresh("other"), other);
  train_into(fresh("tuned"), config(Stage::kFineTune), fresh("from"));
  EXPECT_THAT([&] { train_into(fresh("tuned"), config(Stage::kFineTune), fresh("other")); },
              ThrowsMessage<ArgumentError>(
                  AllOf(HasSubstr("was trained otherwise"), HasSubstr("initial_weights"))));
  EXPECT_THAT([&] { train_into(fresh("tuned"), config(Stage::kFineTune)); },
              ThrowsMessage<ArgumentError>(HasSubstr("initial_weights")));
  EXPECT_THAT([&] { train_into(fresh("from"), config(Stage::kFineTune)); },
              ThrowsMessage<ArgumentError>(HasSubstr("stage: \"pretrain\", not \"fine-tune\"")));
}

TEST_F(PretrainingTest, RefusesAModelThatDoesNotFit) {
  train_into(fresh("from"), config(Stage::kPretrain));
  models::TrainConfig larger = config(Stage::kFineTune);
  larger.duet.hidden = 16;
  larger.duet.cross_layers = 2;
  EXPECT_THAT([&] { train_into(fresh("tuned"), larger, fresh("from")); },
              ThrowsMessage<ArgumentError>(
                  AllOf(HasSubstr("hidden: 8, not 16"), HasSubstr("cross_layers: 1, not 2"))));
  EXPECT_THAT([&] { train_into(fresh("tuned"), config(Stage::kFineTune), fresh("nothing")); },
              ThrowsMessage<std::exception>(HasSubstr("nothing")));
  const models::TrainConfig seq2seq = tests::SmallTraining::config();
  train_into(fresh("seq2seq"), seq2seq);
  EXPECT_THAT([&] { train_into(fresh("tuned"), config(Stage::kFineTune), fresh("seq2seq")); },
              ThrowsMessage<ArgumentError>(HasSubstr("agent: seq2seq, not duet")));
  EXPECT_THAT([&] { train_into(fresh("tuned"), seq2seq, fresh("from")); },
              ThrowsMessage<ArgumentError>(HasSubstr("seq2seq")));
  models::TrainConfig pretrained = seq2seq;
  pretrained.stage = Stage::kPretrain;
  EXPECT_THAT([&] { train_into(fresh("tuned"), pretrained); },
              ThrowsMessage<ArgumentError>(HasSubstr("stage pretrain")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural
