#include "enfilade/geometry/camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "enfilade/core/errors.h"

namespace enfilade {
namespace EN_UNIT {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

TEST(Camera, SquarePicturesSpanTheSameBothWays) {
  EXPECT_NEAR(horizontal_field_of_view({224, 224, Radians(1.1)}).value, 1.1, 1e-15);
}

TEST(Camera, FieldOfViewOfThePaper) {
  // 2 atan(tan(30 deg) * 4 / 3) = 75.18 deg; the linear rule of MatterSim says 80.
  EXPECT_NEAR(to_degrees(horizontal_field_of_view(Camera{})), 75.178, 5e-4);
}

TEST(Camera, RefusesWhatCannotBeAPicture) {
  EXPECT_NO_THROW(validate(Camera{}));
  EXPECT_THAT(([] {
                validate(Camera{0, 480, Radians(1)});
              }),
              ThrowsMessage<ArgumentError>(HasSubstr("camera size 0 x 480")));
  for (const double vfov : {0.0, -1.0, kPi, std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THAT(([&] {
                  validate(Camera{640, 480, Radians(vfov)});
                }),
                ThrowsMessage<ArgumentError>(HasSubstr("field of view")));
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade
