#include "enfilade/models/training_log.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "enfilade/core/errors.h"
#include "enfilade/core/file.h"
#include "enfilade/models/detail/event_file.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::models {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
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

TEST(TrainingHistory, ReadsTrainingAndEvaluations) {
  const TrainingHistory log =
      parse_training_log("{\"type\": \"start\", \"time\": \"now\"}\n" + train(1, 2) + train(2, 1) +
                             evaluation(2, "val_seen", 9) + "\n" + "{\"type\": \"news\"}\n",
                         "log.jsonl");
  ASSERT_EQ(log.training.size(), 2U);
  EXPECT_EQ(log.training[1].iteration, 2U);
  EXPECT_EQ(log.training[1].loss, 1);
  EXPECT_EQ(log.seconds(), 1);
  ASSERT_EQ(log.evaluations.size(), 1U);
  EXPECT_EQ(log.evaluations[0].nav_error, 9);
  EXPECT_EQ(log.evaluations[0].success_rate, 0.25);
  EXPECT_TRUE(std::isnan(log.evaluations[0].loss));
}

TEST(TrainingHistory, WhatWasDoneAgainAfterACheckpointCounts) {
  const TrainingHistory log = parse_training_log(
      train(1, 4) + train(2, 3) + evaluation(2, "val_seen", 9) + train(3, 2) + train(2, 30) +
          evaluation(2, "val_seen", 8) + evaluation(2, "val_unseen", 7),
      "log.jsonl");
  ASSERT_EQ(log.training.size(), 2U);
  EXPECT_EQ(log.training[1].loss, 30);
  EXPECT_EQ(log.seconds(), 1) << "of the iterations that count";
  ASSERT_EQ(log.evaluations.size(), 2U);
  EXPECT_EQ(log.evaluations[0].nav_error, 8);
}

TEST(TrainingHistory, ALastLineWithoutItsEndIsNotReadYet) {
  const TrainingHistory log = parse_training_log(train(1, 4) + R"({"type": "tra)", "log.jsonl");
  EXPECT_EQ(log.training.size(), 1U);
}

TEST(TrainingHistory, NamesTheLineThatIsBroken) {
  EXPECT_THAT([] { parse_training_log(train(1, 4) + "{\n", "log.jsonl"); },
              ThrowsMessage<InvalidInput>(HasSubstr("log.jsonl, line 2")));
  EXPECT_THAT([] { parse_training_log("{\"type\": \"train\", \"iteration\": 1}\n", "log.jsonl"); },
              ThrowsMessage<InvalidInput>(HasSubstr("loss")));
}

class TrainingLogTest : public ::testing::Test {
 protected:
  static EvaluationRecord evaluation(std::uint64_t iteration) {
    return {iteration, "val_seen", 1020, 1.25, 9.5, 8, 0.25, 0.5, 0.125};
  }

  // What a run leaves behind that was killed after a checkpoint at 20.
  void write_run() {
    TrainingLog log(path_, 0);
    log.start(R"({"a": 1})", 0);
    log.add(TrainRecord{10, 1.5, 2});
    log.add(TrainRecord{20, 1.25, 2});
    log.add(evaluation(20));
    log.add(TrainRecord{30, 1.125, 2});
    log.add(evaluation(30));
  }

  std::vector<nlohmann::json> lines() const {
    std::vector<nlohmann::json> all;
    const std::string text = read_file(path_);
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = text.find('\n', at);
      all.push_back(nlohmann::json::parse(text.substr(at, end - at)));
      at = end + 1;
    }
    return all;
  }

  std::vector<std::string> types() const {
    std::vector<std::string> all;
    for (const auto& line : lines()) {
      all.push_back(line["type"].get<std::string>() + std::to_string(line["iteration"].get<int>()));
    }
    return all;
  }

  // Of the event file that is there; there must be one.
  std::string events() const {
    std::string found;
    int count = 0;
    for (const auto& entry : fs::directory_iterator(folder_.path())) {
      if (!entry.path().filename().string().starts_with("events.out.tfevents.")) continue;
      found = read_file(entry.path());
      ++count;
    }
    EXPECT_EQ(count, 1);
    return found;
  }

  tests::TemporaryFolder folder_{"training_log"};
  fs::path path_ = folder_.path() / "log.jsonl";
};

TEST_F(TrainingLogTest, SpeakerRecordsAreReadBackAndShownAgain) {
  {
    TrainingLog log(path_, 0);
    log.add(TrainRecord{10, 1.5, 2});
    log.add(SpeakerRecord{10, "val_seen", 1020, 2, 7.5, 0.25, 0.125});
    log.add(SpeakerRecord{20, "val_seen", 1020, 1, 2.75, 0.5, 0.25});
  }
  const TrainingLog again(path_, 10);
  const TrainingHistory history = load_training_log(path_);
  ASSERT_EQ(history.speaker.size(), 1U) << "that of 20 will be done again";
  EXPECT_EQ(history.speaker[0].split, "val_seen");
  EXPECT_EQ(history.speaker[0].instructions, 1020U);
  EXPECT_EQ(history.speaker[0].perplexity, 7.5);
  EXPECT_EQ(history.speaker[0].accuracy, 0.25);
  EXPECT_EQ(history.speaker[0].bleu, 0.125);
  EXPECT_THAT(events(), HasSubstr("val_seen/bleu"));
  EXPECT_TRUE(history.evaluations.empty());
}

TEST_F(TrainingLogTest, SaysWhatTheReportReads) {
  write_run();
  const auto all = lines();
  ASSERT_EQ(all.size(), 6U);
  EXPECT_EQ(all[0]["type"], "start");
  EXPECT_EQ(all[0]["config"]["a"], 1);
  EXPECT_EQ(all[1]["loss"], 1.5);
  EXPECT_EQ(all[1]["seconds"], 2);
  EXPECT_EQ(all[3]["split"], "val_seen");
  EXPECT_EQ(all[3]["episodes"], 1020);
  EXPECT_EQ(all[3]["trajectory_length"], 9.5);
  EXPECT_EQ(all[3]["nav_error"], 8);
  EXPECT_EQ(all[3]["success_rate"], 0.25);
  EXPECT_EQ(all[3]["oracle_success_rate"], 0.5);
  EXPECT_EQ(all[3]["spl"], 0.125);
}

TEST_F(TrainingLogTest, CutsOffWhatComesAfterTheCheckpoint) {
  write_run();
  TrainingLog log(path_, 20);
  EXPECT_THAT(types(), ElementsAre("start0", "train10", "train20", "evaluation20"));
  log.add(TrainRecord{30, 1, 2});
  EXPECT_THAT(types(), ElementsAre("start0", "train10", "train20", "evaluation20", "train30"));
}

TEST_F(TrainingLogTest, CutsOffAHalfWrittenLine) {
  write_run();
  std::string text = read_file(path_);
  text.resize(text.size() - 20);
  write_file_atomically(path_, text);
  const TrainingLog log(path_, 100);
  EXPECT_THAT(types(), ElementsAre("start0", "train10", "train20", "evaluation20", "train30"));
}

TEST_F(TrainingLogTest, WritesTheEventsAnew) {
  write_run();
  const std::string before = events();
  { const TrainingLog log(path_, 20); }
  const std::string after = events();
  const auto count = [](const std::string& text, const std::string& what) {
    std::size_t n = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
      ++n;
    return n;
  };
  EXPECT_EQ(count(before, "train/loss"), 3U);
  EXPECT_EQ(count(after, "train/loss"), 2U);
  EXPECT_EQ(count(before, "val_seen/"), 12U);
  EXPECT_EQ(count(after, "val_seen/"), 6U);
}

TEST_F(TrainingLogTest, RefusesAFileThatIsNoLog) {
  write_file_atomically(path_, "hello\nworld\n");
  EXPECT_THAT([&] { TrainingLog(path_, 0); },
              ThrowsMessage<InvalidInput>(HasSubstr("log.jsonl, line 1")));
}

TEST_F(TrainingLogTest, AFullDiskIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "no /dev/full on this system";
  detail::AppendFile full("/dev/full");
  EXPECT_THAT([&] { full.write("x"); }, ThrowsMessage<FileError>(HasSubstr("No space left")));
}

}  // namespace EN_UNIT
}  // namespace enfilade::models
