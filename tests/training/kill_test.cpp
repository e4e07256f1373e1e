// Training that is killed: the real program, the real signal.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/core/rng.h"
#include "enfilade/synth/small_building.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

class KillTest : public ::testing::Test {
 protected:
  KillTest() { synth::write_small_dataset(folder_.path() / "data", 3); }

  pid_t start(const fs::path& model) const {
    const std::string data = folder_.path() / "data", output = model;
    std::vector<std::string> words{EN_PROGRAM,
                                   "train",
                                   "--data",
                                   data,
                                   "-o",
                                   output,
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
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t quiet;
    posix_spawn_file_actions_init(&quiet);
    posix_spawn_file_actions_addopen(&quiet, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
    pid_t process = 0;
    EXPECT_EQ(posix_spawn(&process, EN_PROGRAM, &quiet, nullptr, arguments.data(), environ), 0);
    posix_spawn_file_actions_destroy(&quiet);
    return process;
  }

  // The exit status, or minus the signal that ended it.
  static int wait(pid_t process) {
    int status = 0;
    waitpid(process, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }

  tests::TemporaryFolder folder_{"kill"};
};

TEST_F(KillTest, KilledAtRandomMomentsTrainingGivesTheSameWeightsToTheBit) {
  const fs::path whole = folder_.path() / "whole", killed = folder_.path() / "killed";
  const Clock::time_point begin = Clock::now();
  ASSERT_EQ(wait(start(whole)), 0);
  const auto duration = std::chrono::duration_cast<std::chrono::microseconds>(Clock::now() - begin);

  Rng rng(static_cast<std::uint64_t>(begin.time_since_epoch().count()));
  int kills = 0;
  for (int attempt = 0; attempt < 8; ++attempt) {
    const pid_t process = start(killed);
    const double share = 0.1 + 0.7 * rng.uniform();
    std::this_thread::sleep_for(duration * share);
    kill(process, SIGKILL);
    const int end = wait(process);
    if (end == -SIGKILL) ++kills;
    ASSERT_TRUE(end == -SIGKILL || end == 0) << end;
  }
  ASSERT_EQ(wait(start(killed)), 0);
  EXPECT_GT(kills, 0);
  RecordProperty("kills", kills);
  for (const char* file : {"weights.safetensors", "checkpoint.safetensors", "vocabulary.txt",
                           "config.json", "results/val_unseen.json"}) {
    EXPECT_EQ(read_file(killed / file), read_file(whole / file)) << file;
  }
}

}  // namespace
}  // namespace enfilade
