#include "enfilade/core/threads.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <fstream>
#include <stdexcept>
#include <thread>
#include <vector>

namespace enfilade {
namespace EN_UNIT {

TEST(ParallelFor, VisitsEachItemOnceWhateverTheSplit) {
  for (const int threads : {0, 1, 2, 7}) {
    for (const std::size_t grain : {std::size_t{1}, std::size_t{10}, std::size_t{2000}}) {
      std::vector<int> visits(1000, 0);
      parallel_for(visits.size(), grain, threads, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) ++visits[i];
      });
      EXPECT_EQ(visits, std::vector<int>(1000, 1)) << threads << " threads, grain " << grain;
    }
  }
}

TEST(ParallelFor, NothingToDo) {
  parallel_for(0, 1, 0, [](std::size_t, std::size_t) { FAIL(); });
}

TEST(ParallelFor, ThrowsOnTheCaller) {
  for (const int threads : {1, 2}) {
    EXPECT_THROW(parallel_for(100, 1, threads,
                              [](std::size_t begin, std::size_t) {
                                if (begin == 0) throw std::runtime_error("x");
                              }),
                 std::runtime_error);
  }
}

TEST(ParallelFor, ACallInABodyRunsNoOtherBodyOfTheOuterCall) {
  if (available_threads() < 3) {
    GTEST_SKIP() << "two cores: none is free while another has bodies of the outer call left";
  }
  std::atomic<int> nested{0};
  for (int times = 0; times < 50; ++times) {
    parallel_for(16, 1, 4, [&](std::size_t outer, std::size_t) {
      thread_local bool inside = false;
      if (inside) ++nested;
      inside = true;
      // Uneven, so that this thread has to wait for others.
      parallel_for(8, 1, 4, [&](std::size_t inner, std::size_t) {
        std::this_thread::sleep_for(
            std::chrono::microseconds(100 * ((7 * inner + 3 * outer) % 11)));
      });
      inside = false;
    });
  }
  EXPECT_EQ(nested, 0);
}

// Bytes of memory that this process has.
std::size_t resident() {
  std::size_t pages = 0;
  std::ifstream file("/proc/self/statm");
  file >> pages >> pages;
  return pages * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

TEST(ParallelFor, CallsKeepNoMemory) {
  if (available_threads() == 1) GTEST_SKIP() << "one core: nothing is shared";
  const auto call = [](int times) {
    std::atomic<std::size_t> sum{0};
    for (int k = 0; k < times; ++k) {
      parallel_for(64, 8, 0, [&](std::size_t first, std::size_t last) { sum += last - first; });
    }
    return sum.load();
  };
  EXPECT_EQ(call(100), 6400U);
  const std::size_t before = resident();
  call(4000);
  // An arena of oneTBB for each call would be 28 MB; threads that begin late, their stacks: 1.
  EXPECT_LT(resident(), before + 8'000'000);
}

}  // namespace EN_UNIT
}  // namespace enfilade
