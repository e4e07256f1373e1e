// Verbs that go on where they were: the real program, killed at random moments, leaves nothing that
// an uninterrupted run would not, and its results are the same to the bit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "enfilade/core/rng.h"
#include "enfilade/mesh/read_mesh.h"
#include "tests/support/folder_content.h"
#include "tests/support/furnished_room.h"
#include "tests/support/kills.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::tests {
namespace EN_UNIT {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Words = std::vector<std::string>;

/// A folder for all rows of the table, made by the first that needs it.
const fs::path& made(void (*make)(const fs::path& folder)) {
  static std::map<void (*)(const fs::path&), TemporaryFolder> folders;
  const auto [at, fresh] = folders.try_emplace(make, "kills");
  if (fresh) make(at->second.path());
  return at->second.path();
}

void make_mesh(const fs::path& folder) { mesh::write_obj(furnished_rooms(), folder, "room"); }

void expect_runs(Words words) {
  words.insert(words.begin(), EN_PROGRAM);
  EXPECT_EQ(Process(words).wait(), 0) << words.at(1);
}

// Homes, and an encoder that has learnt little.
void make_homes(const fs::path& folder) {
  const std::string homes = folder / "homes";
  expect_runs({"homes", "-o", homes, "--preset", "training", "--homes", "6", "--tasks", "r2r"});
  expect_runs({"pretrain", "--data", homes, "-o", folder / "encoder.safetensors", "--pictures",
               "40", "--epochs", "1"});
}

// Also the features, which a kill of their own verb is about.
void make_study(const fs::path& folder) {
  make_homes(folder);
  expect_runs({"features", "--data", folder / "homes", "--encoder", "home", "--weights",
               folder / "encoder.safetensors", "-o", folder / "features.safetensors"});
}

struct KilledVerb {
  std::string name;
  bool learns;                            ///< is in builds with libtorch alone
  void (*begin)(const fs::path& output);  ///< makes the folder before the first run
  Words (*words)(const fs::path& output);
};
void PrintTo(const KilledVerb& verb, std::ostream* out) { *out << verb.name; }

void begin_empty(const fs::path& output) { fs::create_directories(output); }

const std::vector<KilledVerb>& verbs() {
  static const std::vector<KilledVerb> kVerbs{
      {"scan_mesh", false, begin_empty,
       [](const fs::path& output) -> Words {
         return {"scan-mesh",
                 made(make_mesh) / "room.obj",
                 "--scan",
                 "room",
                 "-o",
                 output,
                 "--parts",
                 "all",
                 "--size",
                 "64",
                 "--image-width",
                 "160"};
       }},
      {"features", true, begin_empty,
       [](const fs::path& output) -> Words {
         const fs::path& data = made(make_homes);
         return {"features",
                 "--data",
                 data / "homes",
                 "--scan",
                 "home0001",
                 "--encoder",
                 "home",
                 "--weights",
                 data / "encoder.safetensors",
                 "-o",
                 output / "features.safetensors"};
       }},
      {"study", true,
       [](const fs::path& output) {
         fs::copy(made(make_study), output, fs::copy_options::recursive);
       },
       [](const fs::path& output) -> Words {
         return {"study",        "-o", output,    "--homes", "3,2",      "--seeds", "1",
                 "--iterations", "8",  "--batch", "4",       "--hidden", "8"};
       }}};
  return kVerbs;
}

class KilledVerbs : public ::testing::TestWithParam<KilledVerb> {
 protected:
  void SetUp() override {
    if (GetParam().learns && !EN_LEARNS) GTEST_SKIP() << "this build has no libtorch";
  }
  static Words words(const fs::path& output) {
    Words all = GetParam().words(output);
    all.insert(all.begin(), EN_PROGRAM);
    return all;
  }
  /// What is in an output, without logs of training: they have times, and TensorBoard's are named
  /// by them.
  static std::map<std::string, std::string> files(const fs::path& output) {
    auto all = content_of(output);
    std::erase_if(all, [](const auto& file) {
      return file.first.ends_with("log.jsonl") || file.first.find("tfevents") != std::string::npos;
    });
    return all;
  }

  TemporaryFolder folder_{"kills"};
};

TEST_P(KilledVerbs, GoOnAndLeaveNothing) {
  const fs::path whole = folder_.path() / "whole", output = folder_.path() / "output";
  GetParam().begin(whole);
  const Words uninterrupted = words(whole);
  const Clock::time_point start = Clock::now();
  ASSERT_EQ(Process(uninterrupted).wait(), 0);
  const auto duration = Clock::now() - start;
  const auto expected = files(whole);

  const auto expect_same = [&] {
    const auto found = files(output);
    std::vector<std::string> differ;
    for (const auto& [file, bytes] : expected) {
      const auto one = found.find(file);
      if (one == found.end() || one->second != bytes) differ.push_back(file);
    }
    for (const auto& [file, bytes] : found) {
      if (!expected.contains(file)) differ.push_back("left over: " + file);
    }
    EXPECT_THAT(differ, ::testing::IsEmpty());
  };
  Rng rng(static_cast<std::uint64_t>(start.time_since_epoch().count()));
  GetParam().begin(output);
  for (int killed = 0; killed < kills();) {
    Process run(words(output));
    const Clock::time_point moment = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                                        duration * (0.7 * rng.uniform()));
    if (run.killed_when([&] { return Clock::now() >= moment; })) {
      ++killed;
      continue;
    }
    ASSERT_EQ(run.wait(), 0);
    expect_same();
    fs::remove_all(output);
    GetParam().begin(output);
  }
  ASSERT_EQ(Process(words(output)).wait(), 0);
  expect_same();
}

INSTANTIATE_TEST_SUITE_P(All, KilledVerbs, ::testing::ValuesIn(verbs()),
                         [](const auto& verb) { return verb.param.name; });

}  // namespace EN_UNIT
}  // namespace enfilade::tests
