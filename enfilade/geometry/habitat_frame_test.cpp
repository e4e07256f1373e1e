#include "enfilade/geometry/habitat_frame.h"

#include <gtest/gtest.h>

namespace enfilade {
namespace EN_UNIT {

TEST(HabitatFrame, TurnsUpIntoY) {
  EXPECT_EQ(to_habitat(Vec3d{1, 2, 3}), (Vec3d{1, 3, -2}));
  EXPECT_EQ(from_habitat(Vec3d{1, 3, -2}), (Vec3d{1, 2, 3}));
  // Right-handed stays right-handed.
  EXPECT_EQ(cross(to_habitat(Vec3d{1, 0, 0}), to_habitat(Vec3d{0, 1, 0})),
            to_habitat(Vec3d{0, 0, 1}));
}

// Forward of a yaw psi is (-sin psi, 0, -cos psi) in Habitat: docs/tasks.md.
TEST(HabitatFrame, KeepsTheDirectionOfAHeading) {
  for (int degree = -720; degree <= 720; degree += 7) {
    const Radians heading = degrees(degree);
    const HabitatYaw yaw = to_habitat(heading);
    const double psi = 2 * std::atan2(yaw.y, yaw.w);
    const Vec3d forward = from_habitat(Vec3d{-std::sin(psi), 0, -std::cos(psi)});
    EXPECT_NEAR(forward.x, std::sin(heading.value), 1e-12);
    EXPECT_NEAR(forward.y, std::cos(heading.value), 1e-12);
    const Radians back = from_habitat(yaw);
    EXPECT_NEAR(std::remainder(back.value - heading.value, 2 * kPi), 0, 1e-12);
    EXPECT_GE(back.value, 0);
    EXPECT_LT(back.value, 2 * kPi);
    EXPECT_NEAR(from_habitat(HabitatYaw{-yaw.y, -yaw.w}).value, back.value, 1e-9);  // sign free
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade
