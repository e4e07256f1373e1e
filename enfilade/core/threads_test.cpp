#include "enfilade/core/threads.h"

#include <gtest/gtest.h>

#include <stdexcept>
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

}  // namespace EN_UNIT
}  // namespace enfilade
