#include "enfilade/core/ids.h"

#include <gtest/gtest.h>

#include <type_traits>

namespace enfilade {
namespace EN_UNIT {

static_assert(sizeof(ViewpointIndex) == sizeof(std::uint32_t));
static_assert(std::is_trivially_copyable_v<ViewpointIndex>);
static_assert(!std::is_convertible_v<ScanIndex, ViewpointIndex>);
static_assert(!std::is_convertible_v<int, ViewpointIndex>);

TEST(Index, OrdersByValue) {
  EXPECT_LT(ViewpointIndex(1), ViewpointIndex(2));
  EXPECT_EQ(ViewpointIndex(7).at(), 7U);
}

}  // namespace EN_UNIT
}  // namespace enfilade
