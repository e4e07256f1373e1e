#include "enfilade/geometry/vec.h"

#include <gtest/gtest.h>
#include <cmath>
#include <limits>

#include "enfilade/geometry/cube_map.h"

namespace enfilade {
namespace EN_UNIT {

// A quarter turn about z takes x to y and y to -x.
constexpr Mat3d kQuarter{{0, -1, 0, 1, 0, 0, 0, 0, 1}};

TEST(Mat3d, MapsVectorsAndProductsOneAfterTheOther) {
  EXPECT_EQ(kQuarter * (Vec3d{1, 2, 3}), (Vec3d{-2, 1, 3}));
  EXPECT_EQ(kQuarter * kQuarter * (Vec3d{1, 2, 3}), (Vec3d{-1, -2, 3}));
  EXPECT_EQ(transpose(kQuarter) * kQuarter, Mat3d{});
}

TEST(Mat3d, IsTheUpperLeftPartOfAPose) {
  const std::array<double, 16> pose = pose_matrix(kQuarter, {5, 6, 7});
  EXPECT_EQ(pose, (std::array<double, 16>{0, -1, 0, 5, 1, 0, 0, 6, 0, 0, 1, 7, 0, 0, 0, 1}));
  EXPECT_EQ(rotation_of(pose), kQuarter);
}

TEST(IsRotation, HoldsForTurnsAndNotForMirrorsOrScales) {
  EXPECT_TRUE(is_rotation({}));
  EXPECT_TRUE(is_rotation(kQuarter));
  EXPECT_TRUE(is_rotation(world_from_camera(Radians(1.2), Radians(-0.4))));
  EXPECT_FALSE(is_rotation({{-1, 0, 0, 0, 1, 0, 0, 0, 1}}));  // left-handed
  EXPECT_FALSE(is_rotation({{2, 0, 0, 0, 2, 0, 0, 0, 2}}));
  EXPECT_FALSE(is_rotation({{1, 0.1, 0, 0, 1, 0, 0, 0, 1}}));  // sheared
  EXPECT_FALSE(is_rotation({{1, 0, 0, 0, 1, 0, 0, 0, 0}}));
}

TEST(IsRotation, TakesWhatSixDigitsLeave) {
  Mat3d rounded = world_from_camera(Radians(2.3), Radians(0.6));
  for (double& x : rounded.m) x = std::round(x * 1e6) / 1e6;
  EXPECT_TRUE(is_rotation(rounded));
  // A column of length 1 + e gives 1 + 2 e, to first order, on the product's diagonal.
  EXPECT_TRUE(is_rotation({{1 + 0.49e-3, 0, 0, 0, 1, 0, 0, 0, 1}}));
  EXPECT_FALSE(is_rotation({{1 + 0.51e-3, 0, 0, 0, 1, 0, 0, 0, 1}}));
}

TEST(IsRotation, IsFalseForWhatIsNoNumber) {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (std::size_t i = 0; i < 9; ++i) {
      Mat3d m;
      m.m[i] = bad;
      EXPECT_FALSE(is_rotation(m)) << i;
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade
