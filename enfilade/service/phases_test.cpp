#include "enfilade/service/phases.h"

#include <gmock/gmock.h>

#include "enfilade/core/errors.h"
#include "tests/support/refusal.h"

namespace enfilade::service {
namespace {

using ::testing::HasSubstr;

TEST(Phases, AreReadWithTheirDefaults) {
  const auto phases = parse_phases(
      R"({"phases": [{"name": "val", "split": "val_unseen"},
                     {"name": "test", "title": "Test", "split": "test", "annotations": "a.json",
                      "scores": "hidden", "per_day": 3}]})",
      "phases.json");
  ASSERT_EQ(phases.size(), 2U);
  EXPECT_EQ(phases[0].title, "val");
  EXPECT_EQ(phases[0].scores, Scores::kPublic);
  EXPECT_FALSE(phases[0].goals_secret());
  EXPECT_EQ(phases[1].scores, Scores::kHidden);
  EXPECT_EQ(phases[1].per_day, 3);
  EXPECT_TRUE(phases[1].goals_secret());
}

TEST(Phases, EveryFaultIsNamedWithItsPath) {
  const std::string said = tests::refusal<InvalidInput>([] {
    parse_phases(R"({"phases": [{"name": "Val!", "split": "x"}, {"split": "x"},
                     {"name": "a", "split": "b", "scores": "secret"},
                     {"name": "b", "split": "b", "per_day": 0},
                     {"name": "c", "split": "b"}, {"name": "c", "split": "b"}]})",
                 "phases.json");
  });
  EXPECT_THAT(said, HasSubstr("phases.json: $.phases[0].name: \"Val!\", not 1 to 40 of a-z"));
  EXPECT_THAT(said, HasSubstr("$.phases[1]"));
  EXPECT_THAT(said, HasSubstr("$.phases[2].scores: \"secret\", not \"public\" or \"hidden\""));
  EXPECT_THAT(said, HasSubstr("$.phases[3].per_day: 0, not from 1 to 1000"));
  EXPECT_THAT(said, HasSubstr("$.phases[5]: \"c\" is there twice"));
}

}  // namespace
}  // namespace enfilade::service
