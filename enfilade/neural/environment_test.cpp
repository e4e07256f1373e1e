#include "enfilade/neural/environment.h"

#include <gtest/gtest.h>

namespace enfilade::neural {
namespace {

TEST(ModelAction, NamesAreInTheOrderOfTheNetworksOutputs) {
  EXPECT_EQ(to_string(ModelAction::kLeft), "left");
  EXPECT_EQ(to_string(static_cast<ModelAction>(kModelActions - 1)), "end");
}

}  // namespace
}  // namespace enfilade::neural
