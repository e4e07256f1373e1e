#include "tests/conformance/agents_golden.h"

#include <gmock/gmock.h>
#include <cmath>
#include <limits>

#include "enfilade/core/errors.h"

namespace enfilade::tests {
namespace EN_UNIT {

using nlohmann::json;
using ::testing::HasSubstr;

TEST(AgentsTally, CountsValuesAndMismatchesOfEachFile) {
  AgentsTally tally;
  tally.begin("a");
  tally.equal("id", "x", "x");
  tally.equal("id", 1, 2);
  tally.near("number", 1.0, 1.00005);
  tally.near("number", 1.0, 1.001);
  tally.near("large", 1000.0, 1000.05);
  tally.begin("b");
  tally.near_json("row", json::parse("[null, 0.5]"),
                  std::vector{-std::numeric_limits<double>::infinity(), 0.5});
  ASSERT_EQ(tally.files().size(), 2U);
  EXPECT_EQ(tally.files()[0].values, 5U);
  EXPECT_EQ(tally.files()[0].mismatches, 2U);
  EXPECT_THAT(tally.files()[0].examples[0], HasSubstr("id: recorded 1, ours 2"));
  EXPECT_EQ(tally.files()[1].values, 2U);
  EXPECT_EQ(tally.files()[1].mismatches, 0U);
}

TEST(AgentsTally, WhatIsNoNumberOrLacksElementsIsAMismatch) {
  AgentsTally tally;
  tally.begin("a");
  tally.near("nan", 1.0, std::nan(""));
  tally.near_all("short", std::vector{1.0, 2.0}, std::vector{1.0});
  tally.near("infinite", golden_number(json()), 3.0);
  EXPECT_EQ(tally.files()[0].mismatches, 3U);
  EXPECT_THROW(golden_number(json("x")), Error);
}

}  // namespace EN_UNIT
}  // namespace enfilade::tests
