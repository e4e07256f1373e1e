#include "enfilade/core/threads.h"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/temporary_folder.h"

namespace enfilade {
namespace EN_UNIT {
namespace fs = std::filesystem;

constexpr std::uint64_t kGiB = std::uint64_t{1} << 30;

class AvailableMemory : public ::testing::Test {
 protected:
  AvailableMemory() {
    write("proc/meminfo", "MemTotal: 16777216 kB\nMemFree: 5 kB\nMemAvailable: 8388608 kB\n");
    write("proc/self/cgroup", "4:memory:/old\n0::/jobs/one\n");
  }
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_.path() / name).parent_path());
    std::ofstream(folder_.path() / name) << text;
  }
  std::uint64_t found() const {
    return available_memory(folder_.path() / "proc", folder_.path() / "cgroup");
  }

 private:
  tests::TemporaryFolder folder_{"available_memory"};
};

TEST_F(AvailableMemory, IsTheMachinesWithoutALimit) {
  EXPECT_EQ(found(), 8 * kGiB);
  write("cgroup/jobs/one/memory.max", "max\n");
  write("cgroup/jobs/one/memory.current", "1000\n");
  EXPECT_EQ(found(), 8 * kGiB);
}

TEST_F(AvailableMemory, IsWhatItsContainerHasLeft) {
  write("cgroup/jobs/one/memory.max", std::to_string(3 * kGiB));
  write("cgroup/jobs/one/memory.current", std::to_string(kGiB));
  EXPECT_EQ(found(), 2 * kGiB);
  write("cgroup/jobs/one/memory.current", std::to_string(4 * kGiB));
  EXPECT_EQ(found(), 0U);
}

TEST_F(AvailableMemory, SeesALimitAtTheRootOfAContainersOwnTree) {
  write("cgroup/memory.max", std::to_string(kGiB));
  write("cgroup/memory.current", "0");
  EXPECT_EQ(found(), kGiB);
}

TEST(AvailableMemoryHere, IsMoreThanThisTestTakes) {
  EXPECT_GT(available_memory(), std::uint64_t{16} << 20);
}

}  // namespace EN_UNIT
}  // namespace enfilade
