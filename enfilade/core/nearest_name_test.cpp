#include "enfilade/core/nearest_name.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <string>

namespace enfilade {
namespace EN_UNIT {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr std::array<std::string_view, 7> kNames{"name",  "ends",     "step",   "scores",
                                                 "teams", "per_team", "per_day"};

TEST(NearestNames, AreThoseThatAreMisspelled) {
  EXPECT_THAT(nearest_names("endss", kNames), ElementsAre("ends"));       // one more
  EXPECT_THAT(nearest_names("score", kNames), ElementsAre("scores"));     // one less
  EXPECT_THAT(nearest_names("per-day", kNames), ElementsAre("per_day"));  // another
  EXPECT_THAT(nearest_names("tsep", kNames), ElementsAre("step"));        // two swapped
  EXPECT_THAT(nearest_names("per_taem", kNames), ElementsAre("per_team"));
  EXPECT_THAT(nearest_names("team", kNames), ElementsAre("teams"));
  EXPECT_THAT(nearest_names("Name", kNames), ElementsAre("name"));
}

TEST(NearestNames, OfTwoAreTheNearerOne) {
  constexpr std::array<std::string_view, 2> kTwo{"per_address_day", "per_address"};
  EXPECT_THAT(nearest_names("per_addres", kTwo), ElementsAre("per_address"));
}

TEST(NearestNames, AreNoneThatAreFarAway) {
  EXPECT_THAT(nearest_names("comment", kNames), IsEmpty());
  EXPECT_THAT(nearest_names("", kNames), IsEmpty());
  EXPECT_THAT(nearest_names(std::string(1 << 20, 'x'), kNames), IsEmpty());
  EXPECT_THAT(nearest_names("name", {}), IsEmpty());
}

TEST(NearestNames, AdviceListsTheNamesIfNoneIsNear) {
  EXPECT_EQ(advice_on_name("taems", kNames), "the nearest is \"teams\"");
  EXPECT_EQ(advice_on_name("score", std::array<std::string_view, 2>{"scorer", "scores"}),
            "the nearest are \"scorer\", \"scores\"");
  EXPECT_EQ(advice_on_name("x", std::array<std::string_view, 2>{"name", "split"}),
            "allowed are name, split");
}

}  // namespace EN_UNIT
}  // namespace enfilade
