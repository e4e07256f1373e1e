// The real program, killed at many moments of its work: `enfilade homes` goes on where it was.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "enfilade/homes/home_set.h"
#include "enfilade/scan/connectivity.h"
#include "enfilade/scan/store.h"
#include "tests/support/folder_content.h"
#include "tests/support/process.h"
#include "tests/support/temporary_folder.h"

namespace enfilade::apps {
namespace {

namespace fs = std::filesystem;
using tests::content_of;
using tests::Process;
using tests::TemporaryFolder;

// Two flats with a few pictures: nearly all of the time goes into their light.
std::vector<std::string> pictures_in(const fs::path& folder) {
  return {EN_PROGRAM, "homes",  "-o", folder.string(), "--preset",
          "small",    "--size", "16", "--paths",       "0"};
}
// Three without any, and paths in them.
std::vector<std::string> paths_in(const fs::path& folder) {
  return {EN_PROGRAM, "homes",  "-o", folder.string(), "--preset", "small", "--homes",
          "3",        "--size", "0",  "--paths",       "4"};
}

// That what the list of a folder names is whole, whenever the program was killed.
void expect_whole(const fs::path& folder, bool pictures) {
  if (!fs::exists(folder / "homes.json")) return;
  for (const homes::HomeEntry& home : homes::read_home_list(folder)) {
    const auto graph = scan::load_connectivity(folder / "connectivity", home.scan);
    EXPECT_GT(graph.entries.size(), 0U);
    if (!pictures) continue;
    const auto store = scan::Store::open(scan::store_file(folder / "store", home.scan));
    EXPECT_EQ(store->size(), graph.entries.size());
    EXPECT_TRUE(store->verify().empty()) << home.scan;
  }
}

// What an uninterrupted run makes, and how much work that is.
struct Reference {
  std::map<std::string, std::string> content;
  double work = 0;
};
Reference run_whole(std::vector<std::string> (*arguments)(const fs::path&)) {
  const TemporaryFolder folder("homes");
  Process run(arguments(folder.path()));
  EXPECT_EQ(run.wait(), 0);
  return {content_of(folder.path()), run.work()};
}

void expect_same(const fs::path& folder, const Reference& reference) {
  const auto content = content_of(folder);
  std::vector<std::string> differ;
  for (const auto& [file, bytes] : reference.content) {
    const auto found = content.find(file);
    if (found == content.end() || found->second != bytes) differ.push_back(file);
  }
  for (const auto& [file, bytes] : content) {
    if (!reference.content.contains(file)) differ.push_back("left over: " + file);
  }
  EXPECT_THAT(differ, testing::IsEmpty());
}

// The first half of files of the reference where a kill in the middle of writing them leaves it.
void leave_halves(const fs::path& folder, const Reference& reference,
                  const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    const std::string& whole = reference.content.at(file);
    const fs::path half = folder / (file + (file.ends_with(".enfilade") ? ".part" : ".part4711"));
    fs::create_directories(half.parent_path());
    write_file_atomically(half, whole.substr(0, whole.size() / 2 + 7));
  }
}

// Both kinds of kills need what an uninterrupted run makes; so they are one test.
TEST(KilledHomes, GoOnWherePicturesWereAndGetTheSameBytes) {
  const Reference reference = run_whole(pictures_in);
  ASSERT_THAT(reference.content, testing::Contains(testing::Key("store/home_0002.enfilade")));
  const TemporaryFolder steps("homes"), times("homes");
  // Each appears when the step before it is done.
  for (const char* file :
       {"README.md", "homes.json", "connectivity/home_0001_connectivity.json",
        "store/home_0001.enfilade.part", "connectivity/scans.txt",
        "connectivity/home_0002_connectivity.json", "store/home_0002.enfilade.part"}) {
    const fs::path path = steps.path() / file;
    Process run(pictures_in(steps.path()));
    EXPECT_TRUE(run.killed_when([&] { return fs::exists(path); })) << file;
    expect_whole(steps.path(), true);
  }
  leave_halves(steps.path(), reference,
               {"homes.json", "connectivity/scans.txt", "regions/region_to_panorama.json",
                "connectivity/home_0002_connectivity.json", "store/home_0002.enfilade"});
  EXPECT_EQ(Process(pictures_in(steps.path())).wait(), 0);
  expect_same(steps.path(), reference);

  int kills = 0;
  for (const double share : {0.21, 0.42}) {
    Process run(pictures_in(times.path()));
    kills += run.killed_when([&] { return run.work() > share * reference.work; });
    expect_whole(times.path(), true);
  }
  EXPECT_EQ(kills, 2);
  EXPECT_EQ(Process(pictures_in(times.path())).wait(), 0);
  expect_same(times.path(), reference);
}

// Kills a run that writes paths when `file` is there. These files follow one another within
// milliseconds; who looks too late, as on a busy machine, takes them away and tries again.
bool killed_at(const fs::path& folder, const char* file) {
  constexpr int kAttempts = 50;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    Process run(paths_in(folder));
    if (run.killed_when([&] { return fs::exists(folder / file); })) return true;
    fs::remove_all(folder / "r2r");
    fs::remove_all(folder / "hidden");
  }
  return false;
}

TEST(KilledHomes, GoOnWherePathsWereAndGetTheSameBytes) {
  const Reference reference = run_whole(paths_in);
  ASSERT_THAT(reference.content, testing::Contains(testing::Key("hidden/R2R_test.json")));
  const TemporaryFolder folder("homes");
  for (const char* file : {"connectivity/home_0003_connectivity.json", "r2r", "r2r/R2R_train.json",
                           "r2r/R2R_val_unseen.json", "hidden/R2R_test.json"}) {
    EXPECT_TRUE(killed_at(folder.path(), file)) << file;
    expect_whole(folder.path(), false);
  }
  for (const double share : {0.2, 0.35, 0.5, 0.65}) {
    Process run(paths_in(folder.path()));
    run.killed_when([&] { return run.work() > share * reference.work; });
    expect_whole(folder.path(), false);
  }
  leave_halves(folder.path(), reference,
               {"homes.json", "r2r/R2R_train.json", "r2r/R2R_test.json", "hidden/R2R_test.json"});
  EXPECT_EQ(Process(paths_in(folder.path())).wait(), 0);
  expect_same(folder.path(), reference);
}

}  // namespace
}  // namespace enfilade::apps
