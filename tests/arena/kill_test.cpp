// `enfilade ask` is killed in the middle, again and again: the run goes on, and what was answered
// is not asked again.
#include <gtest/gtest.h>

#include <csignal>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "enfilade/arena/stand_in.h"
#include "enfilade/core/file.h"
#include "enfilade/core/rng.h"
#include "enfilade/dataset/dataset.h"
#include "tests/support/kills.h"
#include "tests/support/process.h"
#include "tests/support/small_homes.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {
namespace EN_UNIT {

namespace fs = std::filesystem;

constexpr std::size_t kParallel = 4;

class AskKill : public ::testing::Test {
 protected:
  AskKill() : folder_("ask_kill") {
    write_small_homes(folder_.path() / "homes");
    const dataset::Dataset data(folder_.path() / "homes");
    episodes_ = std::make_shared<const tasks::EpisodeSet>(data.episodes("val_unseen"));
  }

  std::unique_ptr<arena::World> world() const {
    return std::make_unique<arena::GraphWorld>(episodes_);
  }
  std::vector<std::string> words(const arena::StandIn& model, const std::string& output) const {
    return {EN_PROGRAM,   "ask",
            "--data",     (folder_.path() / "homes").string(),
            "--endpoint", model.url(),
            "--model",    "m",
            "--subset",   "60",
            "--parallel", std::to_string(kParallel),
            "-o",         (folder_.path() / output).string()};
  }
  /// What a run has written, but for its cache, and for its time.
  std::map<std::string, std::string> files(const std::string& name) const {
    std::map<std::string, std::string> all;
    const fs::path folder = folder_.path() / name;
    for (const auto& one : fs::recursive_directory_iterator(folder)) {
      const std::string file = fs::relative(one.path(), folder).string();
      const bool same = one.is_regular_file() && !file.starts_with("cache") && file != "usage.json";
      if (same) all[file] = read_file(one.path());
    }
    return all;
  }

  TemporaryFolder folder_;
  std::shared_ptr<const tasks::EpisodeSet> episodes_;
};

TEST_F(AskKill, TheRunGoesOnAndNothingIsAskedTwice) {
  // Each answer takes 10 ms, so that there is a middle to be killed in.
  const arena::StandIn model(world(), {.rule = arena::Rule::kRandom,
                                       .faults = {arena::StandInFault::kSilence},
                                       .one_in = 1,
                                       .silence = 0.01});
  Rng rng(20);
  int killed = 0;
  for (int k = 0; k < kills(); ++k) {
    const std::size_t until = model.answers() + 1 + rng.below(12);
    Process run(words(model, "killed"));
    killed += run.killed_when([&] { return model.answers() >= until; }) ? 1 : 0;
  }
  EXPECT_EQ(killed, kills());  // 60 episodes of six answers: it never came to its end
  EXPECT_EQ(Process(words(model, "killed")).wait(), 0);
  // Lost is at most what was on its way when it was killed.
  EXPECT_LE(model.repeats(), static_cast<std::size_t>(kills()) * kParallel);
  const std::size_t answered = model.answers() - model.repeats();

  const arena::StandIn fresh(world(), {.rule = arena::Rule::kRandom});
  EXPECT_EQ(Process(words(fresh, "whole")).wait(), 0);
  EXPECT_EQ(fresh.answers(), answered);
  EXPECT_EQ(files("killed"), files("whole"));
}

TEST_F(AskKill, AServerThatIsKilledIsWaitedFor) {
  // It refuses what comes after 30 answers, so that no machine is fast enough to end the run first.
  constexpr std::size_t kAnswers = 30;
  auto model =
      std::make_unique<arena::StandIn>(world(), arena::StandInConfig{.most_answers = kAnswers});
  Process run(words(*model, "run"));
  while (model->answers() < kAnswers) std::this_thread::sleep_for(std::chrono::milliseconds(1));
  model.reset();
  // It asks again six times; then the exit code says that something is left to do.
  EXPECT_EQ(run.wait(), 1);
  const arena::StandIn other(world(), {});
  EXPECT_EQ(Process(words(other, "run")).wait(), 0);
  EXPECT_LT(other.answers(), 400U);
  const arena::StandIn fresh(world(), {});
  EXPECT_EQ(Process(words(fresh, "whole")).wait(), 0);
  EXPECT_EQ(files("run"), files("whole"));
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
