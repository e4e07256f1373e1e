// Training and evaluation in several processes: the real program, the real signal.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "enfilade/core/file.h"
#include "enfilade/core/rng.h"
#include "tests/support/free_port.h"
#include "tests/support/kills.h"
#include "tests/support/process.h"
#include "tests/support/small_homes.h"
#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace EN_UNIT {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using tests::Process;
using Words = std::vector<std::string>;

constexpr int kAgain = 75;

class RankedTraining : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = std::make_unique<tests::TemporaryFolder>("ranks");
    tests::write_small_homes(folder_->path() / "data");
    // A build without Gloo says so.
    Process probe({EN_PROGRAM, "doctor", "--json"}, folder_->path() / "doctor.json");
    probe.wait();
    connects_ = read_file(folder_->path() / "doctor.json").find("c10d's Gloo") != std::string::npos;
  }
  static void TearDownTestSuite() { folder_.reset(); }
  void SetUp() override {
    if (!connects_) GTEST_SKIP() << "this build has no c10d (Debian: libgloo-dev)";
  }

  static fs::path in(const std::string& name) { return folder_->path() / name; }
  static Words training(const fs::path& model, const Words& more) {
    Words words{EN_PROGRAM, "train",    "--data",   in("data"),  "-o",
                model,      "--inputs", "language", "--threads", "1"};
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  // One command as processes of a launcher.
  class Run {
   public:
    Run(const Words& words, int size, const Words& last = {}) : size_(size) {
      const std::string port = std::to_string(tests::free_port());
      for (int k = 0; k < size; ++k) {
        Words own = words;
        if (k + 1 == size) own.insert(own.end(), last.begin(), last.end());
        processes_.push_back(std::make_unique<Process>(
            own, "/dev/null",
            std::map<std::string, std::string>{{"RANK", std::to_string(k)},
                                               {"WORLD_SIZE", std::to_string(size)},
                                               {"LOCAL_RANK", std::to_string(k)},
                                               {"LOCAL_WORLD_SIZE", std::to_string(size)},
                                               {"MASTER_ADDR", "127.0.0.1"},
                                               {"MASTER_PORT", port}},
            error_file(k)));
      }
    }
    Process& process(int rank) { return *processes_.at(static_cast<std::size_t>(rank)); }
    std::vector<int> wait() {
      std::vector<int> codes;
      for (const auto& process : processes_) codes.push_back(process->wait());
      return codes;
    }
    static std::string errors(int rank) { return read_file(error_file(rank)); }
    int size() const { return size_; }

   private:
    static fs::path error_file(int rank) { return in("errors" + std::to_string(rank)); }

    int size_;
    std::vector<std::unique_ptr<Process>> processes_;
  };

  static void run(const Words& words, int size) {
    const std::vector<int> codes = Run(words, size).wait();
    for (std::size_t k = 0; k < codes.size(); ++k) {
      ASSERT_EQ(codes[k], 0) << Run::errors(static_cast<int>(k));
    }
  }
  static void expect_same(const fs::path& a, const fs::path& b) {
    for (const char* file : {"weights.safetensors", "checkpoint.safetensors", "config.json",
                             "results/val_unseen.json", "results/val_unseen.attention.json"}) {
      EXPECT_EQ(read_file(a / file), read_file(b / file)) << b << " " << file;
    }
  }

  static std::unique_ptr<tests::TemporaryFolder> folder_;
  static bool connects_;
};
std::unique_ptr<tests::TemporaryFolder> RankedTraining::folder_;
bool RankedTraining::connects_ = false;

const Words kSeq2Seq{"--hidden",    "24", "--word-embedding", "12",  "--batch", "20",
                     "--max-steps", "8",  "--learning-rate",  "0.01"};

struct Agent {
  std::string name;
  Words options;
};

class RankedAgents : public RankedTraining, public ::testing::WithParamInterface<Agent> {};

TEST_P(RankedAgents, NumbersOfProcessesGiveTheSameBitsAlsoWhereTheyTakeOver) {
  Words options = GetParam().options;
  for (const char* word :
       {"--validation", "val_unseen", "--evaluate-every", "4", "--checkpoint-every", "2"}) {
    options.emplace_back(word);
  }
  const auto with = [&](const char* parts, const char* iterations) {
    Words words = options;
    for (const char* word : {"--iterations", iterations}) words.emplace_back(word);
    if (parts != nullptr) {
      for (const char* word : {"--parts", parts}) words.emplace_back(word);
    }
    return words;
  };
  const fs::path one = in(GetParam().name + "1");
  ASSERT_EQ(Process(training(one, with("8", "6"))).wait(), 0);
  const fs::path four = in(GetParam().name + "4");
  run(training(four, with(nullptr, "6")), 4);
  expect_same(one, four);
  // Begun by eight, gone on by two, ended by one, which finds the number of parts in the folder.
  const fs::path taken_over = in(GetParam().name + "taken_over");
  run(training(taken_over, with(nullptr, "2")), 8);
  run(training(taken_over, with(nullptr, "4")), 2);
  ASSERT_EQ(Process(training(taken_over, with(nullptr, "6"))).wait(), 0);
  expect_same(one, taken_over);
  // The parts are something else than the batch at once.
  if (GetParam().name != "seq2seq") return;  // one code for all agents
  const fs::path whole = in(GetParam().name + "whole");
  ASSERT_EQ(Process(training(whole, with(nullptr, "6"))).wait(), 0);
  EXPECT_NE(read_file(one / "weights.safetensors"), read_file(whole / "weights.safetensors"));
}

INSTANTIATE_TEST_SUITE_P(
    Training, RankedAgents,
    ::testing::Values(Agent{"seq2seq", kSeq2Seq},
                      Agent{"panoramic",
                            {"--agent", "panoramic", "--hidden", "24", "--word-embedding", "12",
                             "--batch", "16", "--max-steps", "8", "--learning-rate", "0.01"}},
                      Agent{"duet",
                            {"--agent", "duet", "--size", "duet-s", "--batch", "8", "--max-steps",
                             "5", "--learning-rate", "0.001"}}),
    [](const auto& agent) { return agent.param.name; });

TEST_F(RankedTraining, RandomRanksKilledTheWeightsAreTheSameToTheBit) {
  Words options = kSeq2Seq;
  for (const char* word : {"--iterations", "600", "--checkpoint-every", "2", "--evaluate-every",
                           "300", "--validation", "val_unseen"}) {
    options.emplace_back(word);
  }
  Words in_parts = options;
  for (const char* word : {"--parts", "8"}) in_parts.emplace_back(word);
  const fs::path whole = in("whole"), killed = in("killed");
  ASSERT_EQ(Process(training(whole, in_parts)).wait(), 0);

  const auto seed =
      static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
  RecordProperty("seed", std::to_string(seed));
  Rng rng(seed);
  // Those that wait for one who died before it was connected cannot know that.
  Words killing = options;
  for (const char* word : {"--timeout", "10"}) killing.emplace_back(word);
  int kills = 0, named = 0;
  const int wanted = tests::kills(), most = 3 * wanted;
  for (int attempt = 0; kills < wanted && attempt < most; ++attempt) {
    const int size = attempt % 2 == 0 ? 4 : 2;
    Run run(training(killed, killing), size);
    const int victim = static_cast<int>(rng.below(static_cast<std::uint64_t>(size)));
    // Some before they are connected, the others in the middle of training.
    const auto written = [&]() -> std::uintmax_t {
      const fs::path log = killed / "log.jsonl";
      return fs::exists(log) ? fs::file_size(log) : 0;
    };
    const auto before = written();
    const auto began = std::chrono::steady_clock::now();
    const auto waited = [&] { return std::chrono::steady_clock::now() - began; };
    while (attempt % 5 != 4 && waited() < std::chrono::seconds(30) && written() <= before + 500) {
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(0.5 * rng.uniform()));
    if (run.process(victim).end() != -SIGKILL) {
      // Trained to the end before that: once more.
      run.wait();
      fs::remove_all(killed);
      continue;
    }
    ++kills;
    const std::vector<int> codes = run.wait();
    for (int k = 0; k < size; ++k) {
      if (k == victim) continue;
      const std::string errors = Run::errors(k);
      // Where rank 0 had not opened the store yet, it cannot be reached.
      EXPECT_THAT(codes[static_cast<std::size_t>(k)], ::testing::AnyOf(kAgain, 2)) << errors;
      named += errors.find("rank " + std::to_string(victim)) != std::string::npos ? 1 : 0;
    }
  }
  EXPECT_EQ(kills, wanted);
  EXPECT_GE(named, wanted);  // by one of the three or the one that live on
  RecordProperty("named", named);
  run(training(killed, options), 4);
  expect_same(whole, killed);
}

TEST_F(RankedTraining, ProcessesThatAreNotAlikeSayWhoDiffersInWhat) {
  Words options = kSeq2Seq;
  for (const char* word : {"--iterations", "2"}) options.emplace_back(word);
  Run run(training(in("unlike"), options), 2, {"--seed", "7"});
  for (const int code : run.wait()) EXPECT_EQ(code, 2);
  for (const int rank : {0, 1}) {
    EXPECT_THAT(Run::errors(rank), HasSubstr("rank 1: /training/seed: 7, not 1"));
  }
  EXPECT_FALSE(fs::exists(in("unlike") / "config.json"));
}

TEST_F(RankedTraining, AFaultOfOneIsToldByTheOthers) {
  Words options = kSeq2Seq;
  for (const char* word : {"--iterations", "2"}) options.emplace_back(word);
  Run run(training(in("fault"), options), 2, {"--buildings", "99"});
  EXPECT_THAT(run.wait(), ::testing::ElementsAre(kAgain, 2));
  EXPECT_THAT(Run::errors(0),
              ::testing::ContainsRegex("rank 1 .* failed: buildings: 99, but split"));
}

TEST_F(RankedTraining, NumbersOfProcessesThatCannotShareThePartsAreNamed) {
  Words options = kSeq2Seq;
  for (const char* word : {"--iterations", "2", "--parts", "4"}) options.emplace_back(word);
  Run run(training(in("odd"), options), 3);
  for (const int code : run.wait()) EXPECT_EQ(code, 2);
  EXPECT_THAT(Run::errors(0), HasSubstr("parts: 4, in 3 processes"));
}

TEST_F(RankedTraining, EvaluationIsSharedAndEachEpisodeIsScoredOnce) {
  for (const Words& agent :
       {kSeq2Seq, Words{"--agent", "panoramic", "--hidden", "24", "--word-embedding", "12"}}) {
    const fs::path model = in("evaluated_" + std::to_string(agent.size()));
    Words options = agent;
    for (const char* word : {"--iterations", "2", "--evaluate-every", "0"}) {
      options.emplace_back(word);
    }
    ASSERT_EQ(Process(training(model, options)).wait(), 0);
    const auto evaluation = [&](const std::string& output) {
      return Words{EN_PROGRAM, "evaluate",   model, "--data",   in("data"),  "--batch", "7",
                   "--split",  "val_unseen", "-o",  in(output), "--threads", "1"};
    };
    ASSERT_EQ(Process(evaluation("alone")).wait(), 0);
    run(evaluation("shared"), 3);
    for (const char* file : {"val_unseen.json", "val_unseen.attention.json"}) {
      EXPECT_EQ(read_file(in("alone") / file), read_file(in("shared") / file)) << file;
    }
  }
}

TEST_F(RankedTraining, AllReduceLearnsTheSameButForRounding) {
  Words options = kSeq2Seq;
  for (const char* word : {"--iterations", "3", "--all-reduce"}) options.emplace_back(word);
  run(training(in("reduced"), options), 2);
  EXPECT_THAT(read_file(in("reduced") / "config.json"), HasSubstr("\"parts\": 0"));
}

}  // namespace EN_UNIT
}  // namespace enfilade
