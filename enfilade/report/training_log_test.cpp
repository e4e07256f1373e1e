#include "enfilade/report/training_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "enfilade/core/errors.h"

namespace enfilade::report {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

std::string train(int iteration, double loss) {
  return R"({"type": "train", "iteration": )" + std::to_string(iteration) + R"(, "loss": )" +
         std::to_string(loss) + R"(, "seconds": 0.5})" + "\n";
}

std::string evaluation(int iteration, const std::string& split, double error) {
  return R"({"type": "evaluation", "iteration": )" + std::to_string(iteration) + R"(, "split": ")" +
         split + R"(", "loss": null, "nav_error": )" + std::to_string(error) +
         R"(, "success_rate": 0.25})" + "\n";
}

TEST(TrainingLog, ReadsTrainingAndEvaluations) {
  const TrainingLog log =
      parse_training_log("{\"type\": \"start\", \"time\": \"now\"}\n" + train(1, 2) + train(2, 1) +
                             evaluation(2, "val_seen", 9) + "\n" + "{\"type\": \"news\"}\n",
                         "log.jsonl");
  ASSERT_EQ(log.training.size(), 2U);
  EXPECT_EQ(log.training[1].iteration, 2);
  EXPECT_EQ(log.training[1].loss, 1);
  EXPECT_EQ(log.seconds, 1);
  ASSERT_EQ(log.evaluations.size(), 1U);
  EXPECT_EQ(log.evaluations[0].nav_error, 9);
  EXPECT_EQ(log.evaluations[0].success, 0.25);
  EXPECT_TRUE(std::isnan(log.evaluations[0].loss));
}

TEST(TrainingLog, WhatWasDoneAgainAfterACheckpointCounts) {
  const TrainingLog log = parse_training_log(
      train(1, 4) + train(2, 3) + evaluation(2, "val_seen", 9) + train(3, 2) + train(2, 30) +
          evaluation(2, "val_seen", 8) + evaluation(2, "val_unseen", 7),
      "log.jsonl");
  ASSERT_EQ(log.training.size(), 2U);
  EXPECT_EQ(log.training[1].loss, 30);
  EXPECT_EQ(log.seconds, 1) << "of the iterations that count";
  ASSERT_EQ(log.evaluations.size(), 2U);
  EXPECT_EQ(log.evaluations[0].nav_error, 8);
}

TEST(TrainingLog, ALastLineWithoutItsEndIsNotReadYet) {
  const TrainingLog log = parse_training_log(train(1, 4) + R"({"type": "tra)", "log.jsonl");
  EXPECT_EQ(log.training.size(), 1U);
}

TEST(TrainingLog, NamesTheLineThatIsBroken) {
  EXPECT_THAT([] { parse_training_log(train(1, 4) + "{\n", "log.jsonl"); },
              ThrowsMessage<InvalidInput>(HasSubstr("log.jsonl, line 2")));
  EXPECT_THAT([] { parse_training_log("{\"type\": \"train\", \"iteration\": 1}\n", "log.jsonl"); },
              ThrowsMessage<InvalidInput>(HasSubstr("loss")));
}

TEST(Thinned, KeepsTheMeanAndTheNumberOfPoints) {
  std::vector<TrainingPoint> points;
  for (int i = 0; i < 1000; ++i) points.push_back({static_cast<double>(i), i % 2 == 0 ? 1.0 : 3.0});
  const auto thin = thinned(points, 400);
  EXPECT_EQ(thin.size(), 334U) << "three at a time, one left";
  EXPECT_EQ(thin[0].iteration, 1);
  EXPECT_NEAR(thin[0].loss, 5.0 / 3, 1e-12) << "(1 + 3 + 1) / 3, rounding aside";
  EXPECT_EQ(thin.back().iteration, 999);
  EXPECT_EQ(thinned(points, 1000).size(), 1000U);
}

}  // namespace
}  // namespace enfilade::report
