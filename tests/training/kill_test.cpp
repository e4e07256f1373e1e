// Training that is killed: the real program, the real signal.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/core/rng.h"
#include "tests/support/process.h"
#include "tests/support/small_homes.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace EN_UNIT {

namespace fs = std::filesystem;
using tests::Process;
using Clock = std::chrono::steady_clock;

class KillTest : public ::testing::Test {
 protected:
  KillTest() { tests::write_small_homes(folder_.path() / "data"); }

  std::vector<std::string> training(const fs::path& model) const {
    return {EN_PROGRAM,
            "train",
            "--data",
            folder_.path() / "data",
            "-o",
            model,
            "--inputs",
            "language",
            "--hidden",
            "24",
            "--word-embedding",
            "12",
            "--iterations",
            "120",
            "--batch",
            "20",
            "--max-steps",
            "8",
            "--checkpoint-every",
            "3",
            "--evaluate-every",
            "20",
            "--threads",
            "1",
            "--learning-rate",
            "0.01"};
  }

  tests::TemporaryFolder folder_{"kill"};
};

TEST_F(KillTest, KilledAtRandomMomentsTrainingGivesTheSameWeightsToTheBit) {
  const fs::path whole = folder_.path() / "whole", killed = folder_.path() / "killed";
  const Clock::time_point begin = Clock::now();
  ASSERT_EQ(Process(training(whole)).wait(), 0);
  const auto duration = std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - begin);

  Rng rng(static_cast<std::uint64_t>(begin.time_since_epoch().count()));
  int kills = 0;
  for (int attempt = 0; attempt < 8; ++attempt) {
    Process process(training(killed));
    const double share = 0.1 + 0.7 * rng.uniform();
    std::this_thread::sleep_for(duration * share);
    const int end = process.end();
    if (end == -SIGKILL) ++kills;
    ASSERT_TRUE(end == -SIGKILL || end == 0) << end;
  }
  ASSERT_EQ(Process(training(killed)).wait(), 0);
  EXPECT_GT(kills, 0);
  RecordProperty("kills", kills);
  for (const char* file : {"weights.safetensors", "checkpoint.safetensors", "vocabulary.txt",
                           "config.json", "results/val_unseen.json"}) {
    EXPECT_EQ(read_file(killed / file), read_file(whole / file)) << file;
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade
