#include "enfilade/core/check.h"

#include <gtest/gtest.h>

namespace EN_UNIT {

TEST(CheckDeathTest, ShowsExpressionAndBothValues) {
  const int found = 3;
  EXPECT_DEATH(EN_CHECK_EQ(found, 4), "found == 4 does not hold: 3 vs 4");
  EXPECT_DEATH(EN_CHECK(found > 5), "found > 5 does not hold");
}

TEST(Check, EvaluatesEachSideOnce) {
  int calls = 0;
  EN_CHECK_LT(calls++, 5);
  EXPECT_EQ(calls, 1);
}

}  // namespace EN_UNIT
