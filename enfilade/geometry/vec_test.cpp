#include "enfilade/geometry/vec.h"

#include <gtest/gtest.h>

namespace enfilade {
namespace EN_UNIT {

TEST(Vec3, LengthAndDifference) {
  constexpr Vec3d kA{1, 2, 3};
  constexpr Vec3d kB{3, 5, 9};
  EXPECT_EQ(kB - kA, (Vec3d{2, 3, 6}));
  EXPECT_EQ(length(kB - kA), 7.0);
  EXPECT_EQ(kA + (kB - kA), kB);
}

TEST(Vec3, MultiplesAndNegation) {
  constexpr Vec3d kA{1, -2, 3};
  EXPECT_EQ(2.0 * kA, (Vec3d{2, -4, 6}));
  EXPECT_EQ(-kA, -1.0 * kA);
  Vec3f sum{1, 1, 1};
  sum += 0.5F * Vec3f{2, 4, 6};
  EXPECT_EQ(sum, (Vec3f{2, 3, 4}));
}

TEST(Vec3, DotIsTheCosineTimesTheLengths) {
  constexpr Vec3d kA{1, 2, 3}, kB{4, -5, 6};
  static_assert(dot(kA, kB) == 4 - 10 + 18);
  EXPECT_EQ(dot(kA, kA), 14.0);
  EXPECT_EQ(dot(Vec3f{3, 0, 4}, Vec3f{0, 7, 0}), 0.0F);  // at right angles
}

TEST(Vec3, CrossIsRightHandedAndAtRightAnglesToBoth) {
  constexpr Vec3d kX{1, 0, 0}, kY{0, 1, 0}, kZ{0, 0, 1};
  EXPECT_EQ(cross(kX, kY), kZ);
  EXPECT_EQ(cross(kY, kZ), kX);
  EXPECT_EQ(cross(kZ, kX), kY);
  constexpr Vec3d kA{1, 2, 3}, kB{4, -5, 6};
  constexpr Vec3d kN = cross(kA, kB);
  EXPECT_EQ(kN, (Vec3d{2 * 6 + 3 * 5, 3 * 4 - 1 * 6, -1 * 5 - 2 * 4}));
  EXPECT_EQ(dot(kN, kA), 0.0);
  EXPECT_EQ(dot(kN, kB), 0.0);
  EXPECT_EQ(cross(kB, kA), -kN);
  EXPECT_EQ(cross(Vec3f{3, 0, 0}, Vec3f{0, 2, 0}), (Vec3f{0, 0, 6}));
}

TEST(Vec3, ChangesItsPrecision) {
  constexpr Vec3d kThird{1.0 / 3, -2, 0.25};
  const Vec3f single = to_float(kThird);
  EXPECT_EQ(single.x, 1.0F / 3);
  EXPECT_EQ(single.y, -2.0F);
  EXPECT_EQ(single.z, 0.25F);
  EXPECT_EQ(to_double({0.1F, 0.5F, -3}), (Vec3d{0.1F, 0.5, -3}));
}

}  // namespace EN_UNIT
}  // namespace enfilade
