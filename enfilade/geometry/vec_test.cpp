#include "enfilade/geometry/vec.h"

#include <gtest/gtest.h>

namespace enfilade {
namespace {

TEST(Vec3, LengthAndDifference) {
  constexpr Vec3d kA{1, 2, 3};
  constexpr Vec3d kB{3, 5, 9};
  EXPECT_EQ(kB - kA, (Vec3d{2, 3, 6}));
  EXPECT_EQ(length(kB - kA), 7.0);
  EXPECT_EQ(kA + (kB - kA), kB);
}

}  // namespace
}  // namespace enfilade
