#include "enfilade/agents/six_actions.h"

#include <gtest/gtest.h>

#include <string>

namespace enfilade::agents {
namespace EN_UNIT {

TEST(SixActions, AreNamedAsInTheReleasedCode) {
  std::string names;
  for (std::int32_t k = 0; k < kSixActionCount; ++k) {
    names += std::string(to_string(static_cast<SixAction>(k))) + " ";
  }
  EXPECT_EQ(names, "left right up down forward end ");
}

TEST(SixActions, ForwardStaysWhereNothingIsAhead) {
  EXPECT_EQ(to_action(SixAction::kForward, 2).index, 1U);
  EXPECT_EQ(to_action(SixAction::kForward, 5).index, 1U);
  EXPECT_EQ(to_action(SixAction::kForward, 1).index, 0U);
}

TEST(SixActions, ComeBackFromTheDecisionThatTheyAre) {
  for (std::int32_t k = 0; k < kSixActionCount; ++k) {
    const auto action = static_cast<SixAction>(k);
    const Decision decision = to_decision(action, 2);
    EXPECT_EQ(decision.stop, action == SixAction::kStop);
    EXPECT_EQ(six_action_of(decision), action) << to_string(action);
  }
  // Any neighbour that is walked to is forward.
  EXPECT_EQ(six_action_of(Decision::go(3)), SixAction::kForward);
}

}  // namespace EN_UNIT
}  // namespace enfilade::agents
