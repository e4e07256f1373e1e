#include "enfilade/neural/core/batches.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace enfilade::neural::core {
namespace EN_UNIT {

std::vector<std::size_t> first_batches(EpisodeOrder order, std::uint64_t count) {
  std::vector<std::size_t> all;
  for (std::uint64_t i = 0; i < count; ++i) {
    const auto batch = order.batch(i);
    all.insert(all.end(), batch.begin(), batch.end());
  }
  return all;
}

TEST(EpisodeOrder, EachPassHasEveryEpisodeOnceAndItsOwnOrder) {
  const auto all = first_batches(EpisodeOrder(10, 4, 1), 10);  // four passes
  std::set<std::vector<std::size_t>> orders;
  for (std::size_t pass = 0; pass < 4; ++pass) {
    std::vector<std::size_t> one(all.begin() + static_cast<std::ptrdiff_t>(10 * pass),
                                 all.begin() + static_cast<std::ptrdiff_t>(10 * pass + 10));
    orders.insert(one);
    std::ranges::sort(one);
    EXPECT_THAT(one, ::testing::ElementsAre(0, 1, 2, 3, 4, 5, 6, 7, 8, 9));
  }
  EXPECT_EQ(orders.size(), 4U);
}

TEST(EpisodeOrder, ABatchIsAFunctionOfSeedAndIteration) {
  EpisodeOrder walked(10, 4, 7);
  for (std::uint64_t i = 0; i < 20; ++i) walked.batch(i);
  EpisodeOrder fresh(10, 4, 7);
  EXPECT_TRUE(std::ranges::equal(walked.batch(13), fresh.batch(13)));
  EXPECT_NE(first_batches(EpisodeOrder(10, 4, 7), 5), first_batches(EpisodeOrder(10, 4, 8), 5));
}

TEST(EpisodeOrder, BatchesMayBeLargerThanTheSet) {
  const auto all = first_batches(EpisodeOrder(3, 7, 1), 3);
  EXPECT_EQ(std::ranges::count(all, std::size_t{0}), 7);
}

}  // namespace EN_UNIT
}  // namespace enfilade::neural::core
