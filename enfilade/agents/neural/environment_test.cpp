#include "enfilade/agents/neural/environment.h"

#include <gtest/gtest.h>

namespace enfilade::agents::neural {
namespace {

TEST(ModelAction, NamesAreInTheOrderOfTheNetworksOutputs) {
  EXPECT_EQ(to_string(ModelAction::kLeft), "left");
  EXPECT_EQ(to_string(static_cast<ModelAction>(kModelActions - 1)), "end");
}

}  // namespace
}  // namespace enfilade::agents::neural
