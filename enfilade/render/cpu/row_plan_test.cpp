#include "enfilade/render/cpu/row_plan.h"

#include <gtest/gtest.h>

#include "enfilade/core/rng.h"

namespace enfilade::render::cpu {
namespace EN_UNIT {

// Pixels that the plan puts on another face than project_to_cube() does.
std::size_t differing_pixels(const Camera& camera, const Mat3d& rotation) {
  const PixelRays rays = pixel_rays(camera, rotation);
  const ViewPlan plan(rays);
  std::size_t differing = 0;
  for (std::uint32_t row = 0; row < camera.height; ++row) {
    Stretches stretches;
    plan.plan(row, camera.width, stretches);
    std::uint32_t column = 0;
    for (const RowStretch& stretch : stretches.all()) {
      EXPECT_EQ(stretch.begin, column);  // they cover the row, from left to right
      for (; column < stretch.end; ++column) {
        differing += project_to_cube(rays.at(row, column)).face != face_of(stretch) ? 1 : 0;
      }
    }
    EXPECT_EQ(column, camera.width);
  }
  return differing;
}

TEST(ViewPlan, AgreesWithAskingEachPixel) {
  Rng rng(7, 0);
  for (int k = 0; k < 300; ++k) {
    const Camera camera{1 + static_cast<std::uint32_t>(rng.below(200)),
                        1 + static_cast<std::uint32_t>(rng.below(100)),
                        degrees(1 + 178 * rng.uniform())};
    ASSERT_EQ(differing_pixels(camera, world_from_camera(Radians(rng.uniform() * 7),
                                                         Radians((rng.uniform() - .5) * kPi))),
              0U)
        << "view " << k;
  }
}

TEST(ViewPlan, HoldsWhereEdgesRunAlongRowsAndThroughCorners) {
  for (const double heading : {0., 45., 90., 135.}) {
    for (const double elevation : {-90., -45., 0., 45., 90.}) {
      const Camera camera{90, 90, degrees(90)};
      // A row that runs along an edge may be put on either side of it, pixel by pixel.
      EXPECT_LE(differing_pixels(camera, world_from_camera(degrees(heading), degrees(elevation))),
                2U * 90U);
    }
  }
}

TEST(ViewPlan, LinesMeetTheirFace) {
  const Camera camera{64, 48, degrees(70)};
  const PixelRays rays = pixel_rays(camera, world_from_camera(Radians(0.4), Radians(0.2)));
  const ViewPlan plan(rays);
  constexpr std::uint32_t kSize = 512;
  for (std::uint32_t row = 0; row < camera.height; ++row) {
    Stretches stretches;
    plan.plan(row, camera.width, stretches);
    for (const RowStretch& stretch : stretches.all()) {
      const FaceLine line = face_line(rays, row, face_of(stretch), kSize);
      const float j = static_cast<float>(stretch.begin), ahead = line.d0 + j * line.d1;
      const FacePoint point = project_to_cube(rays.at(row, stretch.begin));
      // From the middle of the border's texel, half a texel before the face's edge; in 65536ths.
      const auto texels = [](float value, float d) { return value / d / 65536 - 0.5; };
      // Single precision of numbers up to 2^25.
      EXPECT_NEAR(texels(line.x0 + j * line.x1, ahead), point.s * kSize, 2e-4);
      EXPECT_NEAR(texels(line.y0 + j * line.y1, ahead), point.t * kSize, 2e-4);
    }
  }
}

}  // namespace EN_UNIT
}  // namespace enfilade::render::cpu
