#include "enfilade/render/detail/shared_cells.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>

#include <cstring>
#include <fstream>
#include <thread>
#include <vector>

#include "enfilade/core/errors.h"
#include "tests/support/shared_memory.h"

namespace enfilade::render::detail {
namespace EN_UNIT {

using ClaimResult = SharedCells::ClaimResult;
using ::testing::HasSubstr;
using tests::in_child;
using tests::wait_for;

constexpr std::size_t kMebi = std::size_t{1} << 20U;
constexpr std::size_t kFace = 32 << 10U;  // two slots of a segment of 64 KiB

auto soon() { return std::chrono::steady_clock::now() + std::chrono::seconds(10); }

SharedKey key(std::uint64_t number) { return {number, ~number}; }

void fill(const SharedCells::Claim& claim, std::uint64_t number, std::size_t bytes = kFace) {
  std::memset(claim.cells, static_cast<int>(number % 251), bytes);
}

bool is_filled(const SharedCells::Claim& claim, std::uint64_t number, std::size_t bytes = kFace) {
  return std::all_of(claim.cells, claim.cells + bytes,
                     [&](std::uint8_t value) { return value == number % 251; });
}

// The face, decoded if it is not there.
SharedCells::Claim get(SharedCells& cells, std::uint64_t number, std::size_t bytes = kFace) {
  auto claim = cells.claim(key(number), bytes, soon());
  if (claim.found == ClaimResult::kMine) {
    fill(claim, number, bytes);
    cells.finish(claim.pin);
  }
  return claim;
}

// As many faces as there is room for, pinned.
std::vector<SharedCells::Claim> pin_all(SharedCells& cells) {
  std::vector<SharedCells::Claim> pinned;
  for (std::uint64_t k = 0;; ++k) {
    auto claim = get(cells, k);
    if (claim.found == ClaimResult::kNoRoom) return pinned;
    pinned.push_back(std::move(claim));
  }
}

TEST(SharedCells, ShowsAFaceToOthersOnceItIsFinished) {
  const tests::SharedName name("finished");
  SharedCells one({name.path(), kMebi}), other({name.path(), kMebi});
  auto mine = one.claim(key(7), kFace);
  ASSERT_EQ(mine.found, ClaimResult::kMine);
  EXPECT_EQ(other.claim(key(7), kFace).found, ClaimResult::kElsewhere);
  fill(mine, 7);
  one.finish(mine.pin);
  const auto theirs = other.claim(key(7), kFace);
  ASSERT_EQ(theirs.found, ClaimResult::kReady);
  EXPECT_NE(theirs.cells, mine.cells);  // another mapping
  EXPECT_TRUE(is_filled(theirs, 7));
  EXPECT_EQ(other.claim(key(7), 2 * kFace).found,
            ClaimResult::kMine);  // not taken for another size
}

TEST(SharedCells, AFaceThatIsGivenUpIsDecodedByTheNext) {
  const tests::SharedName name("given_up");
  SharedCells one({name.path(), kMebi}), other({name.path(), kMebi});
  { const auto mine = one.claim(key(7), kFace); }
  EXPECT_EQ(other.claim(key(7), kFace).found, ClaimResult::kMine);
}

TEST(SharedCells, ReplacesWhatWasUsedLeastRecentlyButNothingPinned) {
  const tests::SharedName name("full");
  SharedCells cells({name.path(), kMebi});
  auto pinned = pin_all(cells);
  ASSERT_GE(pinned.size(), 26U);  // of at most 32 in 1 MiB: the table and a segment's end are lost
  EXPECT_EQ(cells.claim(key(1000), kFace).found, ClaimResult::kNoRoom);
  EXPECT_EQ(cells.claim(key(1000), 2 * kFace).found, ClaimResult::kNoRoom);
  pinned[5].pin.reset();
  pinned[3].pin.reset();                                  // later, so used more recently
  EXPECT_EQ(get(cells, 1000).found, ClaimResult::kMine);  // in the place of 5
  EXPECT_EQ(cells.claim(key(3), kFace).found, ClaimResult::kReady);
  for (std::size_t k = 0; k < pinned.size(); ++k) {
    EXPECT_TRUE(k == 3 || k == 5 || is_filled(pinned[k], k)) << k;
  }
  pinned.clear();
  EXPECT_EQ(get(cells, 2000, 2 * kFace).found, ClaimResult::kMine);  // cuts a segment anew
  EXPECT_TRUE(is_filled(get(cells, 2000, 2 * kFace), 2000, 2 * kFace));
  EXPECT_EQ(cells.claim(key(1), 100 * kFace).found, ClaimResult::kNoRoom);  // larger than a segment
  EXPECT_LE(cells.fair_share(), kMebi / 2);
}

// The step at which the child is killed, counted down.
int steps_left = 0;
void count_down() {
  if (--steps_left == 0) raise(SIGKILL);
}

// All that changes the table: joins, decodes, finds, gives up, replaces, cuts anew, leaves.
int use_everything(const std::filesystem::path& path) {
  SharedCells cells({path, kMebi}, count_down);
  get(cells, 0);
  get(cells, 1000);
  { const auto given_up = cells.claim(key(1001), kFace); }
  get(cells, 2000, 2 * kFace);
  get(cells, 1002);
  return 0;
}

TEST(SharedCells, AProcessMayBeKilledAtAnyStep) {
  if (!tests::frees_locks_of_killed()) GTEST_SKIP() << tests::kKeepsLocksOfKilled;
  const tests::SharedName name("killed");
  SharedCells cells({name.path(), kMebi});
  int killed = 0;
  for (int step = 1;; ++step, ++killed) {
    const std::size_t all = pin_all(cells).size();
    ASSERT_GE(all, 26U) << "killed at step " << step - 1;
    const pid_t child = in_child([&] {
      steps_left = step;
      return use_everything(name.path());
    });
    const int status = wait_for(child);
    for (const std::uint64_t number : {0U, 1U, 1000U, 1001U, 1002U}) {
      const auto claim = get(cells, number);
      ASSERT_TRUE(claim.found == ClaimResult::kReady || claim.found == ClaimResult::kMine)
          << "killed at step " << step << ", face " << number;
      ASSERT_TRUE(is_filled(claim, number)) << "killed at step " << step << ", face " << number;
    }
    ASSERT_TRUE(is_filled(get(cells, 2000, 2 * kFace), 2000, 2 * kFace));
    if (status == 0) break;  // it came to its end
    ASSERT_EQ(status, 128 + SIGKILL);
  }
  EXPECT_GT(killed, 40);  // it has about fifty steps
}

TEST(SharedCells, PinsEndWithTheirProcess) {
  const tests::SharedName name("pins");
  SharedCells cells({name.path(), kMebi});
  EXPECT_EQ(wait_for(in_child([&] {
              SharedCells own({name.path(), kMebi});
              const auto pinned = pin_all(own);
              raise(SIGKILL);
              return 0;
            })),
            128 + SIGKILL);
  const auto limit = soon();
  while (cells.claim(key(1000), kFace).found == ClaimResult::kNoRoom) {
    ASSERT_LT(std::chrono::steady_clock::now(), limit);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

void stop() {
  if (--steps_left == 0) raise(SIGSTOP);
}

TEST(SharedCells, NobodyWaitsForEverForAStoppedProcess) {
  if (!tests::frees_locks_of_killed()) GTEST_SKIP() << tests::kKeepsLocksOfKilled;
  const tests::SharedName name("stopped");
  SharedCells cells({name.path(), kMebi});
  const pid_t child = in_child([&] {
    SharedCells own({name.path(), kMebi}, stop);
    steps_left = 1;
    get(own, 1);  // is stopped with the lock
    return 0;
  });
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, WUNTRACED), child);
  ASSERT_TRUE(WIFSTOPPED(status));
  EXPECT_EQ(cells.claim(key(1), kFace).found, ClaimResult::kNoRoom);
  kill(child, SIGKILL);
  EXPECT_EQ(wait_for(child), 128 + SIGKILL);
  EXPECT_EQ(get(cells, 1).found, ClaimResult::kMine);
}

TEST(SharedCells, TheLastUserRemovesTheFile) {
  const tests::SharedName name("last");
  {
    SharedCells one({name.path(), kMebi});
    { SharedCells other({name.path(), kMebi}); }
    EXPECT_TRUE(std::filesystem::exists(name.path()));
    EXPECT_EQ(std::filesystem::file_size(name.path()), kMebi);
    struct stat status {};
    ASSERT_EQ(stat(name.path().c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777U, 0600U);
    // A child that leaves does not speak for its parent.
    EXPECT_EQ(wait_for(in_child([&] {
                one.~SharedCells();
                return 0;
              })),
              0);
    EXPECT_TRUE(std::filesystem::exists(name.path()));
  }
  EXPECT_FALSE(std::filesystem::exists(name.path()));
}

std::string refusal(const std::filesystem::path& path, std::size_t bytes = kMebi) {
  try {
    SharedCells cells({path, bytes});
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(SharedCells, RefusesFilesThatAreNotItsOwn) {
  const tests::SharedName name("foreign");
  const auto change = [&](std::size_t at, std::uint64_t value) {
    std::fstream file(name.path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(at));
    file.write(reinterpret_cast<const char*>(&value), sizeof(value));
  };
  EXPECT_THAT(refusal(name.path(), kMebi + 1), HasSubstr("a whole number of MiB"));
  EXPECT_THAT(refusal(name.path(), std::size_t{1} << 50U), HasSubstr("docker run --shm-size"));
  EXPECT_FALSE(std::filesystem::exists(name.path()));

  std::ofstream(name.path()) << "something else";
  chmod(name.path().c_str(), 0600);
  EXPECT_THAT(refusal(name.path()), HasSubstr("not a shared cache of Enfilade"));
  chmod(name.path().c_str(), 0644);
  EXPECT_THAT(refusal(name.path()), HasSubstr("mode 644"));
  std::filesystem::remove(name.path());

  std::filesystem::create_symlink("/dev/null", name.path());
  EXPECT_THAT(refusal(name.path()), HasSubstr("cannot be opened"));
  std::filesystem::remove(name.path());

  // As a killed process leaves it.
  EXPECT_EQ(wait_for(in_child([&] {
              SharedCells cells({name.path(), kMebi});
              _exit(0);
              return 0;
            })),
            0);
  EXPECT_THAT(refusal(name.path(), 2 * kMebi), HasSubstr("of 1 MiB, not 2 MiB"));
  change(8, SharedFile::kVersion + 1);
  EXPECT_THAT(refusal(name.path()), HasSubstr("version 2, not 1"));
  change(8, SharedFile::kVersion);
  std::filesystem::resize_file(name.path(), kMebi / 2);
  EXPECT_THAT(refusal(name.path()), HasSubstr("524288 bytes, but 1048576 when it was made"));
  std::filesystem::resize_file(name.path(), kMebi);
  change(24, 12345);  // of an earlier start of the machine: made anew
  EXPECT_EQ(refusal(name.path()), "");
}

}  // namespace EN_UNIT
}  // namespace enfilade::render::detail
