#include "enfilade/core/numbers.h"

#include <gtest/gtest.h>
#include <cmath>
#include <cstdint>
#include <limits>

namespace enfilade {
namespace EN_UNIT {

TEST(ParseNumber, ReadsIntegersInBaseTen) {
  EXPECT_EQ(parse_number<int>("0"), 0);
  EXPECT_EQ(parse_number<int>("-17"), -17);
  EXPECT_EQ(parse_number<int>("007"), 7);
  EXPECT_EQ(parse_number<std::uint64_t>("18446744073709551615"),
            std::numeric_limits<std::uint64_t>::max());
}

TEST(ParseNumber, ReadsFloatingPointNumbers) {
  EXPECT_EQ(parse_number<double>("1.5"), 1.5);
  EXPECT_EQ(parse_number<double>("-.25"), -0.25);
  EXPECT_EQ(parse_number<double>("2e3"), 2000.0);
  EXPECT_EQ(parse_number<double>("-inf"), -std::numeric_limits<double>::infinity());
  const auto nan = parse_number<double>("nan");
  ASSERT_TRUE(nan.has_value());
  EXPECT_TRUE(std::isnan(*nan));
}

TEST(ParseNumber, RefusesTextThatIsMoreOrLessThanANumber) {
  for (const char* text : {"", " ", " 1", "1 ", "1\n", "+1", "--1", "-", "1,2", "one", "0x1"}) {
    EXPECT_FALSE(parse_number<int>(text)) << text;
    EXPECT_FALSE(parse_number<double>(text)) << text;
  }
  EXPECT_FALSE(parse_number<int>("1.0"));
  EXPECT_FALSE(parse_number<int>(std::string_view("1\0", 2)));
  EXPECT_FALSE(parse_number<int>({}));
}

TEST(ParseNumber, RefusesWhatIsOutOfRange) {
  EXPECT_EQ(parse_number<std::int8_t>("127"), std::int8_t{127});
  EXPECT_FALSE(parse_number<std::int8_t>("128"));
  EXPECT_FALSE(parse_number<std::uint32_t>("4294967296"));
  EXPECT_FALSE(parse_number<std::uint32_t>("-1"));
  EXPECT_FALSE(parse_number<double>("1e999"));
}

}  // namespace EN_UNIT
}  // namespace enfilade
