#include "enfilade/draw/plan/plan.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace enfilade::draw::plan {
namespace EN_UNIT {
using ::testing::ElementsAre;
using ::testing::IsEmpty;

TEST(SvgNumber, IsShortAndNeverMinusZero) {
  EXPECT_EQ(number(12), "12");
  EXPECT_EQ(number(12.34), "12.3");
  EXPECT_EQ(number(-0.04), "0");
  EXPECT_EQ(pair({1.06, -2}), "1.1,-2");
}

TEST(SvgWrap, BreaksAtBlanks) {
  EXPECT_THAT(wrap("", 10, 100), IsEmpty());
  EXPECT_THAT(wrap("  \n", 10, 100), IsEmpty());
  const double width = text_width("walk out of", 10);
  EXPECT_THAT(wrap(" walk out of  the kitchen ", 10, width),
              ElementsAre("walk out of", "the kitchen"));
  EXPECT_THAT(wrap("unbreakable word", 10, 1), ElementsAre("unbreakable", "word"));
}

TEST(SvgTextWidth, CountsCharactersNotBytes) {
  EXPECT_EQ(text_width("\u00e9\u6771", 10), text_width("ab", 10));
}

}  // namespace EN_UNIT
}  // namespace enfilade::draw::plan
